// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the stages of `Cuda` keep in a device's memory.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <vector>

#include <swiftgs/cuda/backend.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/sort.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/stages.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// Memory that an operation passes to the next of its kind: words of running sums, and two copies of
/// counters, used alternately. An operation adds to one copy and clears the other for its successor.
template <class Counters>
class Epochs {
 public:
  /// For one operation whose running sums take so many words. Clears everything if memory grows or the
  /// kernels of the operation before were not all started.
  EpochsView<Counters> begin(const Cuda& cuda, std::size_t words) {
    const bool keeps = started_ && words <= words_.capacity();
    started_ = false;
    counters_.reset(1), words_.reset(words);
    if (!keeps) {
      cuda.clear(counters_.data(), sizeof(EpochCounters<Counters>));
      cuda.clear(words_.data(), words_.capacity() * sizeof(std::uint64_t));
    }
    const auto capacity = std::uint32_t(words_.capacity());
    return {counters_.data(), words_.data(), capacity, std::bit_ceil(capacity) - 1};
  }
  /// After the last kernel of an operation has been started. That kernel ends the epoch on the device.
  void end() { started_ = true; }

  static auto buffers(auto& self) { return std::tie(self.counters_, self.words_); }

 private:
  DeviceBuffer<EpochCounters<Counters>> counters_;
  DeviceBuffer<std::uint64_t> words_;
  bool started_ = false;
};

/// Copies of the views of a frame, on the device where there is more than one.
template <>
struct ViewStorage<Cuda> {
  std::vector<View> each;
  DeviceBuffer<View> stored;

  static auto buffers(auto& self) { return std::tie(self.stored); }
};

/// On a device placed scenes are in its memory.
template <>
struct SceneStorage<Cuda> {
  std::vector<StoredScene> each;
  DeviceBuffer<StoredScene> stored;

  static auto buffers(auto& self) { return std::tie(self.stored); }
};

/// Stands for counts in an operation that needs only the running sums of `Epochs`.
struct NoCounts {};

/// Memory for the blocks of a projection whose chunks a view may show.
struct BlockScratch {
  Epochs<NoCounts> epochs;
  DeviceBuffer<std::uint32_t> blocks;
  DeviceBuffer<std::uint32_t> count;  ///< of `blocks`

  static auto buffers(auto& self) { return std::tie(self.epochs, self.blocks, self.count); }
};

/// Memory of projection. The next projection clears what this one left: the numbers that `bin` has compared,
/// and the word by which rasterizers know of colourless splats. Rasterize a frame before you project the
/// next.
template <>
struct ProjectScratch<Cuda> {
  Epochs<FrameCounts> epochs;
  DeviceBuffer<std::uint32_t> colourless;  ///< a word that `project` clears and `shade` sets
  DeviceBuffer<FrameTotals> totals;        ///< one, which `bin` fills
  BlockScratch shown;                      ///< written for scenes with chunks alone
  std::uint64_t projections = 0;           ///< so far

  static auto buffers(auto& self) { return std::tie(self.epochs, self.colourless, self.totals, self.shown); }
};

/// A projection whose numbers the host has not read.
struct PendingProjection {
  LastCounters<FrameCounts> counts;
  std::uint32_t* colourless = nullptr;
  FrameTotals* totals = nullptr;
  std::uint64_t projection = 0;  ///< of the scratch memory's; 0: none

  explicit operator bool() const { return projection != 0; }
  bool operator==(const PendingProjection&) const = default;
};

/// The buffers hold the capacity of the frame's limits, or all Gaussians in all views. The device learns from
/// `project` how many are visible; until `bin`, `count` is 0. After `bin` within limits, `count` is an upper
/// bound and `exact` points to the number, until `await_report` tells the host.
template <>
struct Splats<Cuda> : SplatBuffers<Cuda> {
  PendingProjection pending;  ///< from `project` to `bin`; none where the count is known

  /// Sets a number of splats that the host knows.
  void set_count(std::size_t splats) { count = splats, exact = nullptr, pending = {}; }
};

/// Footprints, which projection finds. The buffer holds as many as those of the splats.
template <>
struct Footprints<Cuda> {
  DeviceBuffer<Footprint> each;
  DeviceBuffer<FrameCounts> counts;  ///< of splats of your own
  std::size_t count = 0;             ///< splats, at most
  Count intersections;
  Views views;
  const std::uint64_t* overflowed = nullptr;
  DeviceBuffer<FrameTotals> totals;  ///< of splats of your own
  PendingProjection found_by;
  std::string_view found_within;  ///< name of the bounds that `found_by` used

  FootprintsView view() const { return {{each.data(), count}, intersections, views, overflowed}; }
  static auto buffers(auto& self) { return std::tie(self.each, self.counts, self.totals); }
};

/// A splat, its depth key where the keys of intersections hold one, and the place of its first intersection.
struct EmittedSplat {
  std::uint32_t id = 0, depth = 0, at = 0;
  Footprint footprint;
};

/// Memory of emission.
template <>
struct IntersectionScratch<Cuda> {
  DeviceBuffer<EmittedSplat> large;  ///< splats without a mask
  Epochs<std::uint32_t> epochs;      ///< count them

  static auto buffers(auto& self) { return std::tie(self.large, self.epochs); }
};

/// Memory of grouping by tile.
template <>
struct GroupScratch<Cuda> {
  IntersectionScratch<Cuda> emission;
  Pairs<Cuda, std::uint16_t> narrow;  ///< where 16 bits tell the tiles apart
  Pairs<Cuda, std::uint32_t> wide;

  static auto buffers(auto& self) { return std::tie(self.emission, self.narrow, self.wide); }
};

}  // namespace swiftgs
