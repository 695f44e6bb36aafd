// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/sort/early.hpp>
#include <swiftgs/sort/standard.hpp>

namespace swiftgs {

/// Mean times of the standard and the early sort, of one view of a scene at one image size.
struct SortCalibration {
  std::size_t gaussians = 0;
  int width = 0, height = 0;
  double standard_ms = 0, early_ms = 0;  ///< @units{milliseconds}

  bool prefers_early() const { return early_ms <= standard_ms; }
  bool operator==(const SortCalibration&) const = default;
};

/// Adaptive early sorting (SwiftGS, section 4.2): times both sorts alternately on the frames that it draws,
/// then keeps the faster one on average, until the scene or the image size changes. Saved measurements
/// replace the warm-up. Recorded frames and frames of a scene without identity are never measured; until a
/// sort is chosen they are sorted early. Every frame is correct, measured or not.
class AdaptiveSort {
 public:
  static constexpr std::string_view name = "adaptive";

  /// Measures `frames_each` frames with either sort. The first frame of either does not count, nor does one
  /// for which buffers grew.
  explicit AdaptiveSort(int frames_each = 3) : frames_each_(std::max(frames_each, 1)) {}

  /// Takes earlier measurements, one for each image size, in place of any before. They hold for every scene
  /// of as many Gaussians. The caller ensures that they are of this scene, backend and bounds.
  void use(std::vector<SortCalibration> saved) {
    saved_ = std::move(saved);
    start_over({});  // the next frame looks its own up
  }

  /// The measurement of the last frame's scene and size. No value while frames are still being measured, or
  /// if the frame had several views.
  std::optional<SortCalibration> calibration() const {
    if (!decided_ || key_.views != 1) return std::nullopt;
    return SortCalibration{key_.gaussians, int(key_.width), int(key_.height), measured_[0].mean(),
                           measured_[1].mean()};
  }

  /// A measured frame whose end the backend's clock has not told yet.
  template <class B>
  struct Trial {
    bool early;
    std::array<std::size_t, 2> capacity;
    typename B::TimePoint from, to;
    int asked = 0;
  };

  template <class B>
  struct Scratch {
    StandardSort::Scratch<B> standard;
    EarlySort::Scratch<B> early;
    std::optional<Trial<B>> trial;

    void reserve(B& b, const Reservation& reserved) { reserve_parts(b, reserved, standard, early); }
    static auto buffers(auto& self) { return std::tie(self.standard, self.early); }
  };

  template <class B, class Bounds>
  void build(B& b, const SortJob& job, const Bounds& bounds, Scratch<B>& scratch, TileLists<B>& lists) {
    const auto sort = [&](bool early) {
      if (early)
        EarlySort{}.build(b, job, bounds, scratch.early, lists);
      else
        StandardSort{}.build(b, job, bounds, scratch.standard, lists);
    };
    if (job.use == FrameUse::rehearsed) return sort(false), sort(true);
    if (job.key != key_) start_over(job.key), scratch.trial.reset();
    if (job.use == FrameUse::recorded || job.key.scene == 0) return sort(early_ || !decided_);

    const std::array<std::size_t, 2> capacity{capacity_of(job.splats.count()),
                                              capacity_of(job.footprints.intersections)};
    // A device draws an overflowed frame again with more capacity: its time says nothing.
    if (scratch.trial && scratch.trial->capacity != capacity) scratch.trial.reset();
    collect(b, scratch.trial);
    const bool early = decided_ ? early_ : measured_[1].turns() < measured_[0].turns();
    if (decided_ || scratch.trial) return sort(early);

    const std::size_t held = bytes_of(scratch, lists);
    const auto from = b.now();
    sort(early);
    if (bytes_of(scratch, lists) != held)
      measured_[early].warm = true;
    else
      scratch.trial = Trial<B>{early, capacity, from, b.now()};
    if (!job.footprints.intersections.exact) collect(b, scratch.trial);
  }

 private:
  struct Measured {
    double total_ms = 0;
    int frames = 0;
    bool warm = false;  ///< whether the frame that does not count has been
    int turns() const { return frames + warm; }
    double mean() const { return total_ms / frames; }
  };

  /// A device's capacity. 0 if the host counted, since frames then always fit.
  static std::size_t capacity_of(const Count& count) { return count.exact ? count.most : 0; }

  void start_over(const FrameKey& key) {
    key_ = key;
    measured_ = {};
    decided_ = false;
    if (key.scene == 0 || key.views != 1) return;
    for (const SortCalibration& saved : saved_)
      if (saved.gaussians == key.gaussians && saved.width == key.width && saved.height == key.height) {
        measured_ = {{{saved.standard_ms, 1, true}, {saved.early_ms, 1, true}}};
        decide();
      }
  }

  void decide() {
    decided_ = true;
    early_ = measured_[1].mean() <= measured_[0].mean();
  }

  /// Counts a trial once its end has been reached; never waits for it.
  template <class B>
  void collect(B& b, std::optional<Trial<B>>& trial) {
    if (!trial) return;
    const std::optional<double> ms = b.milliseconds(trial->from, trial->to);
    // A clock may forget points that were not asked for in time: measure again then.
    if (!ms && ++trial->asked < 100) return;
    Measured& m = measured_[trial->early];
    trial.reset();
    if (!ms || !std::exchange(m.warm, true)) return;
    m.total_ms += *ms, ++m.frames;
    if (measured_[0].frames >= frames_each_ && measured_[1].frames >= frames_each_) decide();
  }

  int frames_each_;
  std::vector<SortCalibration> saved_;
  FrameKey key_;
  std::array<Measured, 2> measured_{};  ///< standard, early
  bool early_ = false;                  ///< what was chosen, once `decided_`
  bool decided_ = false;
};

}  // namespace swiftgs
