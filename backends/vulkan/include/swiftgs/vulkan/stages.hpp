// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The stages of `Vulkan`: what they keep in the device's memory, and their overloads. Each takes a policy of
/// the library as its number, which becomes a specialization constant of a shader, and one of a program as
/// its shaders.

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/contribution.hpp>
#include <swiftgs/drivers/pick.hpp>
#include <swiftgs/drivers/statistics.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/sort.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/functor/bounds_stages.hpp>
#include <swiftgs/plane/attribute_stage.hpp>
#include <swiftgs/raster/all.hpp>
#include <swiftgs/sort/early.hpp>
#include <swiftgs/tools/policy_lists.hpp>
#include <swiftgs/vulkan/backend.hpp>
#include <swiftgs/vulkan/shaders.hpp>

namespace swiftgs {

namespace vulkan {

/// Counts of a frame that later stages read, in device memory.
struct FrameTotals {
  FrameReport report;                           ///< projection counts in it
  std::uint32_t splats = 0, intersections = 0;  ///< 0 where the frame overflowed
};

/// A visible Gaussian, whose splat has no place yet, as frame.glsl declares it.
struct Projected {
  float depth;
  std::uint32_t gaussian;
};

/// The number of a policy in its list, as shaders have it.
template <class Policy, class... Policies>
constexpr std::uint32_t index_in(TypeList<Policies...>) {
  std::uint32_t index = 0, found = 0;
  ((std::is_same_v<Policy, Policies> ? void(found = index) : void(), ++index), ...);
  return found;
}
/// Policies with shaders of the program's own.
template <class Bounds>
concept OwnBounds = std::same_as<decltype(shaders<Bounds>), const BoundsShaders* const>;
template <class Raster>
concept OwnRaster = std::same_as<decltype(shaders<Raster>), const RasterShaders* const>;
template <class Bounds>
concept BoundsWithShaders = AllBounds::contains<Bounds> || OwnBounds<Bounds>;
template <class Raster>
concept RasterWithShaders = AllRasters::contains<Raster> || OwnRaster<Raster>;

template <class Exponent>
concept KnownExponent = AllExponents::contains<Exponent>;

/// How a rasterizer computes alpha.
struct RasterKind {
  enum Exponent : std::uint32_t { half_split, float_split, float_cholesky } exponent = float_cholesky;
  bool threshold = true;
  const RasterShaders* own = nullptr;
  std::string_view name{};  ///< of `own`
};
template <class Raster>
struct KindOf;
template <>
struct KindOf<PerPixel> {
  static constexpr RasterKind kind{RasterKind::float_cholesky, false};
};
template <KnownExponent Exponent>
struct KindOf<AxisShared<Exponent>> {
  static constexpr RasterKind kind{RasterKind::Exponent(index_in<Exponent>(AllExponents())), false};
};
template <KnownExponent Exponent>
struct KindOf<AxisSharedThreshold<Exponent>> {
  static constexpr RasterKind kind{RasterKind::Exponent(index_in<Exponent>(AllExponents())), true};
};
template <OwnRaster Raster>
struct KindOf<Raster> {
  static constexpr RasterKind kind{.own = shaders<Raster>, .name = Raster::name};
};

}  // namespace vulkan

/// Memory of projection between its steps.
template <>
struct ProjectScratch<Vulkan> {
  VulkanBuffer<SplatShape> shapes;
  VulkanBuffer<vulkan::Projected> projected;
  VulkanBuffer<std::uint32_t> counts, runs;  ///< visible Gaussians by workgroup, and by run of workgroups

  static auto buffers(auto& self) { return std::tie(self.shapes, self.projected, self.counts, self.runs); }
};

/// Splats on a device. Until `bin`, `exact` points to the number of visible ones, which may exceed the
/// capacity. After `bin` within limits, `count` is an upper bound and `exact` points to the number, until
/// `await_report` tells the host.
template <>
struct Splats<Vulkan> : SplatBuffers<Vulkan> {
  void set_count(std::size_t splats) { count = splats, exact = nullptr; }
};

/// Colours that are evaluated in parts, beside the passes of a sort, and the rest by `finish`.
template <>
class SWIFTGS_API Shading<Vulkan> {
 public:
  Shading(Vulkan& b, const ColoursView& colours) : b_(&b), colours_(colours) {}
  Shading(Shading&& from) noexcept : b_(std::exchange(from.b_, nullptr)), colours_(from.colours_) {}
  ~Shading();
  ColoursView finish();
  void* stream() const { return nullptr; }

 private:
  Vulkan* b_;  ///< null once they are evaluated
  ColoursView colours_;
};

/// Footprints, which projection finds.
template <>
struct Footprints<Vulkan> {
  VulkanBuffer<Footprint> each;
  VulkanBuffer<vulkan::FrameTotals> totals;
  std::string_view found_within;  ///< bounds of projection, until `bin`
  std::size_t count = 0;          ///< splats, at most
  Count intersections;
  Views views;
  const std::uint64_t* overflowed = nullptr;

  FootprintsView view() const { return {{each.data(), count}, intersections, views, overflowed}; }
  static auto buffers(auto& self) { return std::tie(self.each, self.totals); }
};

namespace vulkan {
struct BoundsKind {
  std::uint32_t number;  ///< in `AllBounds`, unless `own`
  std::string_view name;
  const BoundsShaders* own = nullptr;
};
template <BoundsWithShaders Bounds>
inline constexpr BoundsKind bounds_kind{index_in<Bounds>(AllBounds()), Bounds::name};
template <OwnBounds Bounds>
inline constexpr BoundsKind bounds_kind<Bounds>{0, Bounds::name, shaders<Bounds>};

SWIFTGS_API void project(Vulkan& b, const FramePlan& plan, BoundsKind bounds, ProjectScratch<Vulkan>& scratch,
                         Splats<Vulkan>& splats, Footprints<Vulkan>& footprints);
SWIFTGS_API void bin(Vulkan& b, const FramePlan& plan, BoundsKind bounds, Splats<Vulkan>& splats,
                     Footprints<Vulkan>& footprints);

/// Memory as kernels read it.
inline std::uint32_t* words_at(void* data) { return static_cast<std::uint32_t*>(data); }

/// Keys as kernels read them: of one word or two, the lower one first.
struct Keys {
  std::uint32_t* words;
  std::uint32_t each;

  template <class Key>
  explicit Keys(Key* keys) : words(words_at(keys)), each(sizeof(Key) / sizeof(std::uint32_t)) {}
};

SWIFTGS_API void emit(Vulkan& b, const SortJob& job, BoundsKind bounds, const std::uint32_t* order,
                      std::uint32_t* sums, Keys keys, std::uint32_t* ids);
SWIFTGS_API void find_ranges(Vulkan& b, const FootprintsView& footprints, Count count, Keys keys,
                             TileRange* ranges);
SWIFTGS_API void rasterize(Vulkan& b, RasterKind kind, const RasterJob& job);
}  // namespace vulkan

template <vulkan::BoundsWithShaders Bounds>
void project(Vulkan& b, const FramePlan& plan, const Bounds&, ProjectScratch<Vulkan>& scratch,
             Splats<Vulkan>& splats, Footprints<Vulkan>& footprints) {
  vulkan::project(b, plan, vulkan::bounds_kind<Bounds>, scratch, splats, footprints);
}

/// Refuses bounds without shaders.
template <class Bounds>
requires(!vulkan::BoundsWithShaders<Bounds>) void project(Vulkan&, const FramePlan&, const Bounds&,
                                                          ProjectScratch<Vulkan>&, Splats<Vulkan>&,
                                                          Footprints<Vulkan>&) {
  static_assert(vulkan::BoundsWithShaders<Bounds>,
                "bounds: expected some of the library's on the backend Vulkan, or a specialization of "
                "swiftgs::vulkan::shaders by a pointer to BoundsShaders");
}

/// The returned `Shading` refers to `plan`, which must outlive it.
SWIFTGS_API Shading<Vulkan> shade(Vulkan& b, const FramePlan& plan, const Splats<Vulkan>& splats,
                                  Colours<Vulkan>& colours);

/// The device compares the numbers of splats and of intersections with the limits. Waits for the numbers if
/// the limits have no capacity of intersections.
template <vulkan::BoundsWithShaders Bounds>
void bin(Vulkan& b, const FramePlan& plan, const Bounds&, Splats<Vulkan>& splats,
         Footprints<Vulkan>& footprints) {
  vulkan::bin(b, plan, vulkan::bounds_kind<Bounds>, splats, footprints);
}

/// Waits for that comparison.
SWIFTGS_API FrameReport await_report(Vulkan& b, Splats<Vulkan>& splats, Footprints<Vulkan>& footprints,
                                     const Limits& limits);

/// `order_by_depth` from the depths themselves, whose bits are their keys.
SWIFTGS_API const std::uint32_t* order_by_depth(Vulkan& b, const SplatsView& splats,
                                                DepthOrderScratch<Vulkan>& scratch);

/// It trusts the footprints' number of intersections.
template <vulkan::BoundsWithShaders Bounds, class Key>
Count emit_intersections(Vulkan& b, const SortJob& job, const Bounds&, const std::uint32_t* order,
                         IntersectionScratch<Vulkan>& scratch, Pairs<Vulkan, Key>& intersections) {
  check_footprints(job);
  const Count count = job.footprints.intersections;
  check_intersections(count.most);
  // A number of each workgroup, and of runs of workgroups.
  scratch.offsets.reset(job.splats.size() / 64 + 8), intersections.reset(count.most);
  vulkan::emit(b, job, vulkan::bounds_kind<Bounds>, order, scratch.offsets.data(),
               vulkan::Keys(intersections.keys.data()), intersections.values.data());
  return count;
}

template <class Key>
void finish_lists(Vulkan& b, const FootprintsView& footprints, Count count, int,
                  Pairs<Vulkan, Key>& intersections, TileLists<Vulkan>& lists) {
  const std::size_t tiles = footprints.views.tiles.size();
  lists.tiles = lists.intersections = 0;
  lists.ranges.reset(tiles);
  vulkan::find_ranges(b, footprints, count, vulkan::Keys(intersections.keys.data()), lists.ranges.data());
  std::swap(lists.ids, intersections.values);
  lists.tiles = tiles, lists.intersections = count.most;
  intersections.values.reset(count.most);
}

template <vulkan::BoundsWithShaders Bounds>
void group_by_tile(Vulkan& b, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                   GroupScratch<Vulkan>& scratch, TileLists<Vulkan>& lists) {
  const Count count = emit_intersections(b, job, bounds, order, scratch.emission, scratch.intersections);
  b.sort_pairs(scratch.intersections, count, job.footprints.views.tiles.key_bits());
  finish_lists(b, job.footprints, count, 0, scratch.intersections, lists);
}

/// Splats that do not touch a warp block are rejected by one lane.
template <vulkan::RasterWithShaders Raster>
inline constexpr bool may_gain_by_coarse_tiles<Vulkan, Raster> = true;

/// A subgroup blends a warp block of 8x8 pixels, and tests a splat a lane.
template <vulkan::RasterWithShaders Raster>
void rasterize(Vulkan& b, Raster, const RasterJob& job) {
  vulkan::rasterize(b, vulkan::KindOf<Raster>::kind, job);
}

/// Refuses rasterizers without shaders.
template <class Raster>
requires(!vulkan::RasterWithShaders<Raster>) void rasterize(Vulkan&, Raster, const RasterJob&) {
  static_assert(vulkan::RasterWithShaders<Raster>,
                "rasterizer: expected one of the library's on the backend Vulkan, or a specialization of "
                "swiftgs::vulkan::shaders by a pointer to RasterShaders");
}

/// Downloads what `job` was rasterized from, and counts on all cores of the host. Waits.
SWIFTGS_API FrameCounted count_frame(const Vulkan& b, const RasterJob& job, CountRasterBlock count);

/// A thread finds a pixel's Gaussians.
SWIFTGS_API void pick_pixels(Vulkan& b, const PickJob& job);

SWIFTGS_API void add_contributions(Vulkan& b, const ContributionJob& job);
SWIFTGS_API void clear_sums(Vulkan& b, std::uint64_t* sums, std::size_t count);

SWIFTGS_API void gather_attributes(Vulkan& b, const SplatAttributes& from, const StoredScenes& scenes,
                                   const Views& views, AttributeRow* to);

}  // namespace swiftgs
