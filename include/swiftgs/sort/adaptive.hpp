// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include <swiftgs/sort/early.hpp>
#include <swiftgs/sort/standard.hpp>

namespace swiftgs {

/// Mean times of the standard and the early sort. @units{milliseconds}
struct SortTimes {
  double standard = 0, early = 0;

  bool prefers_early() const { return early <= standard; }
};

/// Adaptive early sorting (SwiftGS, section 4.2): times both sorts alternately on the frames that it draws,
/// then keeps the faster one on average, until the scene or the image size changes. Recorded frames and
/// frames of a scene without identity are never measured; until a sort is chosen they are sorted early.
/// Every frame is correct, measured or not.
class AdaptiveSort {
 public:
  static constexpr std::string_view name = "adaptive";

  /// Measures `frames_each` frames with either sort. The first frame of either does not count, nor does one
  /// for which buffers grew.
  explicit AdaptiveSort(int frames_each = 3) : frames_each_(std::max(frames_each, 1)) {}

  /// Times for the last frame's scene and size. No value while frames are still being measured.
  std::optional<SortTimes> measured() const { return measured_; }

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
    if (job.key != key_) {
      key_ = job.key, tallies_ = {}, measured_.reset();
      scratch.trial.reset();
    }
    if (job.use == FrameUse::recorded || job.key.scene == 0)
      return sort(!measured_ || measured_->prefers_early());

    const std::array<std::size_t, 2> capacity{capacity_of(job.splats.count()),
                                              capacity_of(job.footprints.intersections)};
    // A device draws an overflowed frame again with more capacity: its time says nothing.
    if (scratch.trial && scratch.trial->capacity != capacity) scratch.trial.reset();
    collect(b, scratch.trial);
    if (measured_) return sort(measured_->prefers_early());
    const bool early = tallies_[1].turns() < tallies_[0].turns();
    if (scratch.trial) return sort(early);

    const std::size_t held = bytes_of(scratch, lists);
    const auto from = b.now();
    sort(early);
    if (bytes_of(scratch, lists) != held)
      tallies_[early].warm = true;
    else
      scratch.trial = Trial<B>{early, capacity, from, b.now()};
    if (!job.footprints.intersections.exact) collect(b, scratch.trial);
  }

 private:
  struct Tally {
    double total_ms = 0;
    int frames = 0;
    bool warm = false;  ///< whether the frame that does not count has been
    int turns() const { return frames + warm; }
    double mean() const { return total_ms / frames; }
  };

  /// A device's capacity. 0 if the host counted, since frames then always fit.
  static std::size_t capacity_of(const Count& count) { return count.exact ? count.most : 0; }

  /// Counts a trial once its end has been reached; never waits for it.
  template <class B>
  void collect(B& b, std::optional<Trial<B>>& trial) {
    if (!trial) return;
    const std::optional<double> ms = b.milliseconds(trial->from, trial->to);
    // A clock may forget points that were not asked for in time: measure again then.
    if (!ms && ++trial->asked < 100) return;
    Tally& tally = tallies_[trial->early];
    trial.reset();
    if (!ms || !std::exchange(tally.warm, true)) return;
    tally.total_ms += *ms, ++tally.frames;
    if (tallies_[0].frames >= frames_each_ && tallies_[1].frames >= frames_each_)
      measured_ = {tallies_[0].mean(), tallies_[1].mean()};
  }

  int frames_each_;
  FrameKey key_;
  std::array<Tally, 2> tallies_{};  ///< standard, early
  std::optional<SortTimes> measured_;
};

}  // namespace swiftgs
