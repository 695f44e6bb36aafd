// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/sort/calibration.hpp>
#include <swiftgs/sort/early.hpp>
#include <swiftgs/sort/standard.hpp>

namespace swiftgs {

/// Adaptive early sorting (SwiftGS, section 4.2): measures both strategies on the frames that it renders,
/// then keeps the one with the lower mean, until the scene or the image size changes. Stored
/// measurements replace the warm-up. Frames of a scene without identity are sorted early and never measured.
/// Every frame is correct, measured or not.
class AdaptiveSort {
 public:
  static constexpr std::string_view name = "adaptive";

  /// Measures `frames_each` frames with either strategy. The first frame of either does not count, nor does
  /// one for which buffers grew.
  explicit AdaptiveSort(int frames_each = 3) : frames_each_(std::max(frames_each, 1)) {}

  /// The paper's budget: a fifth of `views`, half of it with either strategy.
  static AdaptiveSort for_views(int views) { return AdaptiveSort(views / 10); }

  /// Starts with what `use` takes.
  explicit AdaptiveSort(std::vector<SortCalibration> saved, int frames_each = 3) : AdaptiveSort(frames_each) {
    use(std::move(saved));
  }

  /// Takes earlier measurements of one scene, one for each image size, in place of any before. They hold for
  /// the first scene of as many Gaussians that comes at one of these sizes: its frames at any of them are
  /// sorted by what was measured, from the first on, and not measured again. At other sizes, and of other
  /// scenes, frames are measured as without. Whether the measurements are of this backend and these bounds is
  /// for the caller to know.
  void use(std::vector<SortCalibration> saved) {
    saved_ = std::move(saved);
    saved_scene_ = 0;
    key_ = {};  // looks the next frame's up
    measured_ = {};
    decided_ = false;
  }

  /// What is known of the last frame's scene and size, or nothing while frames are still being measured or if
  /// the frame had several views.
  std::optional<SortCalibration> calibration() const {
    if (!decided_ || key_.views != 1) return std::nullopt;
    return SortCalibration{key_.gaussians, int(key_.width), int(key_.height), measured_[0].mean(),
                           measured_[1].mean()};
  }

  template <class B>
  struct Scratch {
    StandardSort::Scratch<B> standard;
    EarlySort::Scratch<B> early;
    std::optional<typename B::TimePoint> from, to;  ///< measurement whose end has not been seen yet
    bool pending_early = false;
    int waited = 0;  ///< frames for that end

    void reserve(B& b, const FrameRoom& room) { standard.reserve(b, room), early.reserve(b, room); }
    static auto buffers(auto& self) { return std::tie(self.standard, self.early); }
  };

  template <class B, class Bounds>
  void build(B& b, const SortJob<Bounds>& job, const Bounds& bounds, Scratch<B>& scratch,
             TileLists<B>& lists) {
    if (job.rehearse) {
      StandardSort{}.build(b, job, bounds, scratch.standard, lists);
      EarlySort{}.build(b, job, bounds, scratch.early, lists);
      return;
    }
    start_over_where_stale(job.key, scratch);
    if (job.key.scene == 0) {
      EarlySort{}.build(b, job, bounds, scratch.early, lists);
      return;
    }
    if (!job.measure) {
      if (decided_ && !early_)
        StandardSort{}.build(b, job, bounds, scratch.standard, lists);
      else
        EarlySort{}.build(b, job, bounds, scratch.early, lists);
      return;
    }
    collect(b, scratch);
    const bool measure = !decided_ && !scratch.to;
    const bool early =
        decided_ ? early_
                 : measured_[1].frames + measured_[1].warm_ups < measured_[0].frames + measured_[0].warm_ups;
    // Buffers change places between the scratch and the lists. Lists that come empty may be new in every
    // frame, and are no reason to measure none, unless the scratch is empty too, as after `Renderer::trim`.
    const std::size_t held = bytes_of(scratch, lists);
    const bool compare = held == 0 || bytes_of(lists) != 0;
    if (measure) scratch.from = b.now();
    if (early)
      EarlySort{}.build(b, job, bounds, scratch.early, lists);
    else
      StandardSort{}.build(b, job, bounds, scratch.standard, lists);
    const bool grew = compare && bytes_of(scratch, lists) != held;
    if (measure && grew)
      scratch.from.reset(), measured_[early].warm_ups = 1;
    else if (measure)
      scratch.to = b.now(), scratch.pending_early = early;
    // A device's frame may turn out to have had no room: its renderer discards it before the next.
    if (!job.footprints.instances.exact) collect(b, scratch);
  }

  /// Does not count the last frame, which overflowed.
  template <class B>
  void discard(Scratch<B>& scratch) {
    scratch.from.reset(), scratch.to.reset(), scratch.waited = 0;
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
    if (key == key_) return;
    key_ = key;
    measured_ = {};
    decided_ = false;
    pending.from.reset(), pending.to.reset(), pending.waited = 0;
    if (const SortCalibration* saved = saved_for(key)) {
      measured_ = {{{saved->standard_ms, 1, 0}, {saved->early_ms, 1, 0}}};
      early_ = saved->prefers_early();
      decided_ = true;
    }
  }

  const SortCalibration* saved_for(const FrameKey& key) {
    if (key.scene == 0 || (saved_scene_ != 0 && saved_scene_ != key.scene)) return nullptr;
    const auto found = std::find_if(saved_.begin(), saved_.end(), [&](const SortCalibration& saved) {
      return saved.gaussians == key.gaussians && saved.width == key.width && saved.height == key.height &&
             key.views == 1;
    });
    if (found == saved_.end()) return nullptr;
    saved_scene_ = key.scene;
    return &*found;
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
  std::vector<SortCalibration> saved_;
  std::uint64_t saved_scene_ = 0;  ///< which of all scenes `saved_` is of, once it has come
  FrameKey key_;
  std::array<Measured, 2> measured_{};  ///< standard, early
  bool early_ = false;
  bool decided_ = false;
};

}  // namespace swiftgs
