// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <istream>
#include <limits>
#include <optional>
#include <ostream>
#include <string>

#include <swiftgs/sort/early.hpp>
#include <swiftgs/sort/standard.hpp>

namespace swiftgs {

/// What `AdaptiveSort` measured: mean sort time of either strategy for one scene at one image size.
struct SortCalibration {
  std::size_t gaussians = 0;
  int width = 0, height = 0;
  double standard_ms = 0, early_ms = 0;

  bool prefers_early() const { return early_ms <= standard_ms; }
};

/// One line of text, with as many digits as bring the same durations back.
inline std::ostream& operator<<(std::ostream& out, const SortCalibration& c) {
  const std::streamsize precision = out.precision(std::numeric_limits<double>::max_digits10);
  out << "swiftgs-sort-calibration 1 " << c.gaussians << ' ' << c.width << ' ' << c.height << ' '
      << c.standard_ms << ' ' << c.early_ms << '\n';
  out.precision(precision);
  return out;
}

/// Reads what `operator<<` wrote; sets failbit on anything else.
inline std::istream& operator>>(std::istream& in, SortCalibration& c) {
  std::string tag;
  int version = 0;
  SortCalibration read;
  if (in >> tag >> version >> read.gaussians >> read.width >> read.height >> read.standard_ms >>
          read.early_ms &&
      tag == "swiftgs-sort-calibration" && version == 1 && read.width > 0 && read.height > 0 &&
      read.standard_ms >= 0 && read.early_ms >= 0)
    c = read;
  else
    in.setstate(std::ios::failbit);
  return in;
}

/// Adaptive early sorting (SwiftGS, section 4.2): measures both strategies on the frames that it renders,
/// then keeps the one with the lower mean, until the scene or the image size changes. Every frame is correct,
/// measured or not.
class AdaptiveSort {
 public:
  static constexpr std::string_view name = "adaptive";

  /// Measures `frames_each` frames with either strategy; the first frame of either grows buffers and does not
  /// count.
  explicit AdaptiveSort(int frames_each = 3) : frames_each_(std::max(frames_each, 1)) {}

  /// The paper's budget: a fifth of `views`, half of it with either strategy.
  static AdaptiveSort for_views(int views) { return AdaptiveSort(views / 10); }

  /// Starts from an earlier measurement, which holds as long as frames match its scene and size.
  explicit AdaptiveSort(const SortCalibration& saved, int frames_each = 3)
      : frames_each_(std::max(frames_each, 1)),
        key_{nullptr, saved.gaussians, saved.width, saved.height},
        measured_{{{saved.standard_ms, 1, 0}, {saved.early_ms, 1, 0}}},
        early_(saved.prefers_early()),
        decided_(true) {}

  /// The finished measurement, or nothing while frames are still being measured.
  std::optional<SortCalibration> calibration() const {
    if (!decided_) return std::nullopt;
    return SortCalibration{key_.gaussians, key_.width, key_.height, measured_[0].mean(), measured_[1].mean()};
  }

  template <class B>
  struct Scratch {
    StandardSort::Scratch<B> standard;
    EarlySort::Scratch<B> early;
    std::optional<typename B::TimePoint> from, to;  ///< measurement whose end has not been seen yet
    bool pending_early = false;
    int waited = 0;  ///< frames for that end
  };

  template <class B, class Bounds>
  void build(B& b, const SortJob& job, const Bounds& bounds, Scratch<B>& scratch, TileLists<B>& lists) {
    start_over_where_stale(job.key, scratch);
    collect(b, scratch);
    const bool measure = !decided_ && !scratch.to;
    const bool early =
        decided_ ? early_
                 : measured_[1].frames + measured_[1].warm_ups < measured_[0].frames + measured_[0].warm_ups;
    if (measure) scratch.from = b.now();
    if (early)
      EarlySort{}.build(b, job, bounds, scratch.early, lists);
    else
      StandardSort{}.build(b, job, bounds, scratch.standard, lists);
    if (measure) scratch.to = b.now(), scratch.pending_early = early;
    collect(b, scratch);
  }

 private:
  static constexpr int most_frames_waited = 100;
  struct Measured {
    double total_ms = 0;
    int frames = 0;
    int warm_ups = 0;
    double mean() const { return frames ? total_ms / frames : 0; }
  };

  template <class Pending>
  void start_over_where_stale(const FrameKey& key, Pending& pending) {
    const bool same_scene = key_.scene == key.scene || (decided_ && !key_.scene);
    if (same_scene && key_.gaussians == key.gaussians && key_.width == key.width &&
        key_.height == key.height) {
      key_.scene = key.scene;
      return;
    }
    key_ = key;
    measured_ = {};
    decided_ = false;
    pending.from.reset(), pending.to.reset(), pending.waited = 0;
  }

  /// Adds a measurement once its end has been reached; never waits for one.
  template <class B>
  void collect(B& b, Scratch<B>& scratch) {
    if (!scratch.to) return;
    const std::optional<double> ms = b.milliseconds(*scratch.from, *scratch.to);
    // A clock may forget points that were not asked for in time: measure again then.
    if (!ms && ++scratch.waited < most_frames_waited) return;
    scratch.from.reset(), scratch.to.reset(), scratch.waited = 0;
    if (!ms) return;
    Measured& m = measured_[scratch.pending_early];
    if (m.warm_ups == 0) {
      m.warm_ups = 1;
      return;
    }
    m.total_ms += *ms, ++m.frames;
    if (measured_[0].frames >= frames_each_ && measured_[1].frames >= frames_each_) {
      decided_ = true;
      early_ = measured_[1].mean() <= measured_[0].mean();
    }
  }

  int frames_each_;
  FrameKey key_;
  std::array<Measured, 2> measured_{};  ///< standard, early
  bool early_ = false;
  bool decided_ = false;
};

}  // namespace swiftgs
