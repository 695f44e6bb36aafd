// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The backend `Cuda`, and its memory and overloads for each stage.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/bin_stage.hpp>
#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/cuda/backend.hpp>
#include <swiftgs/footprint.hpp>
#include <swiftgs/project_stage.hpp>
#include <swiftgs/raster/all.hpp>
#include <swiftgs/shade_stage.hpp>
#include <swiftgs/sort/early.hpp>
#include <swiftgs/sort/sort.hpp>

namespace swiftgs {

/// Memory that an operation hands on to the next of its kind: words of running sums, and two copies of
/// counters. An operation adds to one copy and clears the other.
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

SWIFTGS_API Views store_views(Cuda& cuda, Span<const View> views, ViewStorage<Cuda>& storage,
                              ViewAccess access = ViewAccess::any);

/// Of operations that `Epochs` keeps running sums for alone.
struct NoCounts {};

/// Memory for the blocks of a projection whose chunks a view may show.
struct BlockScratch {
  Epochs<NoCounts> epochs;
  DeviceBuffer<std::uint32_t> blocks;
  DeviceBuffer<std::uint32_t> count;  ///< of them

  static auto buffers(auto& self) { return std::tie(self.epochs, self.blocks, self.count); }
};

/// Memory of projection. The next projection clears what this one left: the numbers that `bin` has compared,
/// and the word by which rasterizers know of hidden splats. Rasterize a frame before you project the next.
template <>
struct ProjectScratch<Cuda> {
  Epochs<FrameCounts> epochs;
  DeviceBuffer<std::uint32_t> hidden;  ///< a word that `project` clears and `shade` sets
  DeviceBuffer<FrameTotals> totals;    ///< one, which `bin` fills
  BlockScratch shown;                  ///< written for scenes with chunks alone
  std::uint64_t projections = 0;       ///< so far

  static auto buffers(auto& self) { return std::tie(self.epochs, self.hidden, self.totals, self.shown); }
};

/// A projection whose numbers the host has not read.
struct PendingProjection {
  LastCounters<FrameCounts> counts;
  std::uint32_t* hidden = nullptr;
  FrameTotals* totals = nullptr;
  std::uint64_t projection = 0;  ///< of the scratch memory's; 0: none

  explicit operator bool() const { return projection != 0; }
  bool operator==(const PendingProjection&) const = default;
};

/// The buffers have room for as many as the frame's limits say, or for all Gaussians in all views. The device
/// learns from `project` how many are visible; until `bin`, `count` is 0. After `bin` within limits, `count`
/// is the most that there may be and `exact` says how many there are, until `await_report` tells the host.
template <>
struct Splats<Cuda> {
  DeviceBuffer<SplatShape> shapes;
  DeviceBuffer<float> depths;
  DeviceBuffer<std::uint32_t> gaussians;
  DeviceBuffer<std::uint16_t> of_view;   ///< empty if there is one view
  std::size_t count = 0;                 ///< at most
  const std::uint32_t* exact = nullptr;  ///< as `Count::exact`
  PendingProjection pending;             ///< from `project` to `bin`; none where the count is known

  void reset(std::size_t splats, std::size_t views) {
    shapes.reset(splats), depths.reset(splats), gaussians.reset(splats);
    of_view.reset(views > 1 ? splats : 0);
  }
  /// There are so many, and the host knows it.
  void set_count(std::size_t splats) { count = splats, exact = nullptr, pending = {}; }
  SplatsView view() const {
    return {{shapes.data(), count},
            {depths.data(), count},
            {gaussians.data(), count},
            of_view.size() != 0 ? of_view.data() : nullptr,
            exact};
  }
  static auto buffers(auto& self) { return std::tie(self.shapes, self.depths, self.gaussians, self.of_view); }
};

/// Footprints, which projection finds. The buffer has room for as many as those of the splats.
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

/// One kernel: projects, compacts in the order of the Gaussians and finds tiles. Does not wait.
/// In the library for `AllBounds`; for others in `<swiftgs/cuda.cuh>`.
template <BoundsPolicy Bounds>
SWIFTGS_API void project(Cuda& cuda, const FramePlan& plan, const Bounds& bounds,
                         ProjectScratch<Cuda>& scratch, Splats<Cuda>& splats, Footprints<Cuda>& footprints);

/// Colours that are evaluated beside the sort, on a fork.
template <>
class [[nodiscard]] Shading<Cuda> {
 public:
  Shading(Cuda::Fork fork, const Splats<Cuda>& splats, const SplatColour* colours,
          const std::uint32_t* hidden)
      : fork_(std::move(fork)), splats_(&splats), colours_(colours), hidden_(hidden) {}

  /// Call it after `bin`, which sets the number of splats.
  ColoursView finish() {
    fork_.join();
    return {{colours_, splats_->count}, hidden_};
  }
  /// Until `finish`.
  void* stream() const { return fork_.stream(); }

 private:
  Cuda::Fork fork_;
  const Splats<Cuda>* splats_;
  const SplatColour* colours_;
  const std::uint32_t* hidden_;
};

/// Evaluates the colours of `splats`, whose number it reads where the device keeps it, beside all later work
/// until `Shading::finish`.
SWIFTGS_API Shading<Cuda> shade(Cuda& cuda, const FramePlan& plan, const Splats<Cuda>& splats,
                                Colours<Cuda>& colours);

/// Has the device compare the numbers of splats and of intersections with the limits. If those have no
/// capacity of intersections, it waits for the numbers. Finds footprints that `project` has not, and waits
/// for the number of splats where the host does not know it. In the library for `AllBounds`; others:
/// `<swiftgs/cuda.cuh>`.
template <BoundsPolicy Bounds>
SWIFTGS_API void bin(Cuda& cuda, const FramePlan& plan, const Bounds& bounds, Splats<Cuda>& splats,
                     Footprints<Cuda>& footprints);

/// Waits for the device to have compared them. The counts of `splats` and `footprints` are exact then.
inline FrameReport await_report(Cuda& cuda, Splats<Cuda>& splats, Footprints<Cuda>& footprints,
                                const Limits&) {
  const FrameReport report = cuda.await_report();
  if (report.overflowed) return report;
  splats.count = footprints.count = std::size_t(report.visible), splats.exact = nullptr;
  footprints.intersections = std::size_t(report.intersections), footprints.overflowed = nullptr;
  return report;
}

/// `order_by_depth` from the depths themselves, whose bits are their keys.
inline const std::uint32_t* order_by_depth(Cuda& cuda, const SplatsView& splats,
                                           DepthOrderScratch<Cuda>& scratch) {
  const auto* const keys = reinterpret_cast<const std::uint32_t*>(splats.depths.data);
  cuda.sort_positions(keys, splats.count(), depth_key_bits, scratch.pairs);
  return scratch.pairs.values.data();
}

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

/// `emit_intersections` with the tiles of 32 splats spread over the lanes of a warp. The footprints must hold
/// as many intersections as they say: to check would be to wait. In the library for `AllBounds`; for others
/// in `<swiftgs/cuda.cuh>`.
template <BoundsPolicy Bounds, class Key>
SWIFTGS_API Count emit_intersections(Cuda& cuda, const SortJob& job, const Bounds& bounds,
                                     const std::uint32_t* order, IntersectionScratch<Cuda>& scratch,
                                     Pairs<Cuda, Key>& intersections);

/// Memory of grouping by tile.
template <>
struct GroupScratch<Cuda> {
  IntersectionScratch<Cuda> emission;
  Pairs<Cuda, std::uint16_t> narrow;  ///< where 16 bits tell the tiles apart
  Pairs<Cuda, std::uint32_t> wide;

  static auto buffers(auto& self) { return std::tie(self.emission, self.narrow, self.wide); }
};

/// `group_by_tile` with keys no wider than the tiles need.
template <BoundsPolicy Bounds>
void group_by_tile(Cuda& cuda, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                   GroupScratch<Cuda>& scratch, TileLists<Cuda>& lists) {
  const auto group = [&](auto& intersections) {
    const Count count = emit_intersections(cuda, job, bounds, order, scratch.emission, intersections);
    cuda.sort_pairs(intersections, count, job.footprints.views.tiles.key_bits());
    finish_lists(cuda, job.footprints, count, 0, intersections, lists);
  };
  job.footprints.views.tiles.key_bits() <= 16 ? group(scratch.narrow) : group(scratch.wide);
}

/// A thread a pixel, splats in shared memory.
SWIFTGS_API void rasterize(Cuda& cuda, PerPixel, const RasterJob& job);
/// Terms in shared memory, eight splats at a time (SwiftGS, section 5.1).
SWIFTGS_API void rasterize(Cuda& cuda, AxisShared<HalfSplit>, const RasterJob& job);
SWIFTGS_API void rasterize(Cuda& cuda, AxisSharedThreshold<HalfSplit>, const RasterJob& job);
/// Terms in registers, a warp on 8x8 pixels of its own.
SWIFTGS_API void rasterize(Cuda& cuda, AxisShared<FloatSplit>, const RasterJob& job);
SWIFTGS_API void rasterize(Cuda& cuda, AxisSharedThreshold<FloatSplit>, const RasterJob& job);
SWIFTGS_API void rasterize(Cuda& cuda, AxisShared<FloatCholesky>, const RasterJob& job);
SWIFTGS_API void rasterize(Cuda& cuda, AxisSharedThreshold<FloatCholesky>, const RasterJob& job);

/// Warps of these four test each listed splat once. Threads of the others evaluate it at every pixel.
template <>
inline constexpr bool may_gain_by_coarse_tiles<Cuda, AxisShared<FloatSplit>> = true;
template <>
inline constexpr bool may_gain_by_coarse_tiles<Cuda, AxisSharedThreshold<FloatSplit>> = true;
template <>
inline constexpr bool may_gain_by_coarse_tiles<Cuda, AxisShared<FloatCholesky>> = true;
template <>
inline constexpr bool may_gain_by_coarse_tiles<Cuda, AxisSharedThreshold<FloatCholesky>> = true;

/// A rasterizer of the library.
template <class R>
concept LibraryRaster = RasterPolicy<R> && AllRasters::contains<R>;

/// A thread a pixel, by `R::Kernel`: the form of every rasterizer without an overload for it, because
/// overload resolution prefers those. In the library for `AllRasters`; for others in `<swiftgs/cuda.cuh>`.
template <LibraryRaster R>
SWIFTGS_API void rasterize(Cuda& cuda, R, const RasterJob& job);

struct ContributionJob;
/// A warp on 8x8 pixels, as the last of these, with the same bits of every weight.
SWIFTGS_API void add_contributions(Cuda& cuda, const ContributionJob& job);

}  // namespace swiftgs
