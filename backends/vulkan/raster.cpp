// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <swiftgs/contribution.hpp>
#include <swiftgs/drivers/pick.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/float_pair.hpp>
#include <swiftgs/functor/count_on_host.hpp>
#include <swiftgs/vulkan/stages.hpp>

#include "commands.hpp"
#include "planes.hpp"
#include "seen.hpp"

namespace swiftgs::vulkan {
namespace {

struct PlaneWords {
  Address data;
  std::uint32_t pitch[2] = {};

  PlaneWords() = default;
  template <class T>
  explicit PlaneWords(const Plane<T>& plane)
      : data(plane.data),
        pitch{std::uint32_t(plane.pitch), std::uint32_t(std::uint64_t(plane.pitch) >> 32)} {}
};

/// As pixels.glsl declares it.
struct RasterView {
  PlaneWords colour, alpha, depth, first_depth, median_depth, id, median_id, normal, squared_depth, features,
      occluder;
  FloatPair stored_p, stored_q, stored_r, stored_s;
  TileGrid grid;
  std::uint32_t width, height, format, conversion, over, stored_as_depth, feature_channels;
  float least, alpha_max, stop_below, first_below;
  vec3 background;
  vec2 middle;

  explicit RasterView(const View& view)
      : colour(view.frame.colour),
        alpha(view.frame.alpha),
        depth(view.frame.depth),
        first_depth(view.frame.first_depth),
        median_depth(view.frame.median_depth),
        id(view.frame.id),
        median_id(view.frame.median_id),
        normal(view.frame.normal),
        squared_depth(view.frame.squared_depth),
        features(view.frame.features),
        occluder(view.frame.occluder),
        stored_p(FloatPair::from(view.frame.stored_depth.p)),
        stored_q(FloatPair::from(view.frame.stored_depth.q)),
        stored_r(FloatPair::from(view.frame.stored_depth.r)),
        stored_s(FloatPair::from(view.frame.stored_depth.s)),
        grid(view.grid),
        width(std::uint32_t(view.frame.width)),
        height(std::uint32_t(view.frame.height)),
        format(std::uint32_t(view.frame.format)),
        conversion(std::uint32_t(view.frame.conversion)),
        over(view.frame.over),
        stored_as_depth(view.frame.stored_depth.p == 1 && view.frame.stored_depth.q == 0 &&
                        view.frame.stored_depth.r == 0 && view.frame.stored_depth.s == 1),
        feature_channels(std::uint32_t(view.frame.feature_channels)),
        least(view.rules.alpha_min / view.rules.alpha_max),
        alpha_max(view.rules.alpha_max),
        stop_below(view.rules.stop_below),
        first_below(view.rules.first_below),
        background(view.background),
        middle(0.5f * view.camera.width, 0.5f * view.camera.height) {}
};

/// Whether a view is drawn for nothing. Launches over the largest image would take software minutes.
bool has_no_planes(const FrameView& frame) {
  bool none = true;
  for_each_plane([&](std::size_t, const auto& plane) { none = none && !plane.data; }, frame);
  return none;
}

/// Lists that a launch of raster.comp draws.
enum class Lists : std::uint32_t { all, with_many, others };

/// Blends the views one by one, and adds weights to `contributions` where those are given.
void blend(Vulkan& b, RasterKind kind, const RasterJob& job, std::uint64_t* contributions) {
  raster_blocks_of(job);  // checks the number of lists
  Commands commands(b);
  Vulkan::State& state = b.state();
  constexpr std::uint32_t side = raster_side;
  const std::size_t most_groups = state.device.state().most_groups;
  // lavapipe, whose subgroups are small, would compile sums of all pixels of a block for up to 20 seconds.
  const std::uint32_t parts =
      job.attributes.rows != 0 && commands.subgroup() < 32 ? side * side / commands.subgroup() : 1;
  const auto blocks_of = [](const FrameView& frame) {
    return std::size_t((std::uint32_t(frame.width) + side - 1) / side) *
           ((std::uint32_t(frame.height) + side - 1) / side);
  };
  for (const View& view : job.views) {
    if (!contributions && has_no_planes(view.frame)) continue;
    const RasterView words(view);
    const FrameView& frame = view.frame;
    const AttributeList list(view, job.attributes.first, job.attributes.rows);
    const bool is_base = !contributions && !job.only_attributes;
    const auto asks = [](bool yes) { return std::uint32_t(yes); };
    const std::size_t n = job.splats.size(), rows = n * job.attributes.rows;
    const bool sums_depth = job.sums_depth(view) && !view.camera.depth_along_ray;
    const std::uint32_t columns = (std::uint32_t(frame.width) + side - 1) / side,
                        blocks = std::uint32_t(blocks_of(frame));
    const std::size_t of_tile =
        std::size_t(view.grid.side / int(side)) * std::size_t(view.grid.side / int(side));
    const bool knows_long = parts == 1 && n >= long_list && job.lists.ranges.data == state.long_of &&
                            std::min(state.long_tiles.size(), job.lists.ranges.size) * of_tile <= most_groups;
    // A workgroup draws colour, alpha and depths of means of a block of a long list, a subgroup all that
    // there is.
    const bool by_workgroups = is_base && job.attributes.rows == 0 && !job.picks(view) && !frame.occluder;
    const Uniform uniform = commands.uniform(words);
    const auto draw = [&](const Shader& shader, Lists lists, const Commands::Shape& shape) {
      Push push(uniform, reads(job.splats.shapes.data, n), reads(job.colours.each.data, n),
                reads(job.splats.gaussians.data, n), reads(job.lists.ids.data, job.lists.ids.size),
                reads(job.lists.ranges.data, job.lists.ranges.size),
                address(commands.constants(Span<const AttributeList>{&list, 1})),
                reads(job.attributes.data, rows),
                reads(job.attributes.first_row, n * job.attributes.first_stride), shares(contributions, 1),
                reads(state.long_tiles.data(), state.long_tiles.size()),
                job.attributes.first_stride * AttributeRow::channels, std::uint32_t(lists));
      // The views of a frame do not overlap in memory, nor do the planes of its passes.
      for_each_plane(
          [&](std::size_t, const auto& plane) { push.touch(pixels_of(plane, frame.height, Access::shared)); },
          frame);
      push.touch(pixels_of(frame.occluder, frame.height, Access::read));
      commands.run(
          shader,
          {kind.exponent, asks(kind.threshold), asks(sums_depth), asks(job.picks(view)),
           asks(bool(frame.occluder)), asks(frame.conversion != Conversion::as_is),
           job.attributes.rows * AttributeRow::channels, asks(is_base), asks(view.camera.depth_along_ray),
           asks(contributions != nullptr), asks(!contributions || job.colours.each.data), parts},
          push, shape);
    };
    const Shader raster(Kernel::raster, kind, &RasterShaders::raster);
    const Shader raster_long(Kernel::raster_long, kind, &RasterShaders::raster_long);
    const Commands::Shape all{columns, blocks / std::max(columns, 1u), commands.subgroup(), parts};
    if (knows_long)
      draw(by_workgroups ? raster_long : raster, Lists::with_many,
           {.columns = 1,
            .threads = by_workgroups ? commands.sort_threads() : commands.subgroup(),
            .at = Vulkan::State::long_launch});
    draw(raster, knows_long ? Lists::others : Lists::all, all);
  }
  if (state.awaited && !contributions)
    commands.finish();  // timestamps may follow
  else
    commands.submit();
}

}  // namespace

void rasterize(Vulkan& b, RasterKind kind, const RasterJob& job) {
  for (const View& view : job.views) check_colours(view.frame);
  blend(b, kind, job, nullptr);
}

}  // namespace swiftgs::vulkan

namespace swiftgs {

void add_contributions(Vulkan& b, const ContributionJob& job) {
  vulkan::blend(b, vulkan::KindOf<AxisSharedThreshold<FloatCholesky>>::kind, job.raster, job.sums);
}

void clear_sums(Vulkan& b, std::uint64_t* sums, std::size_t count) {
  vulkan::Commands commands(b);
  commands.fill(vulkan::words_at(sums), 2 * count, 0);
  commands.submit();
}

void pick_pixels(Vulkan& b, const PickJob& job) {
  static_assert(sizeof(PickedPixel) == 20 && PickedPixel::nothing == 0xffffffff);
  const vulkan::RasterView view(job.view);
  const std::size_t n = job.splats.size();
  vulkan::Commands commands(b);
  commands.run(vulkan::Kernel::pick, {},
               vulkan::Push(commands.uniform(view), vulkan::reads(job.splats.shapes.data, n),
                            vulkan::reads(job.colours.data, n), vulkan::reads(job.splats.gaussians.data, n),
                            vulkan::reads(job.lists.ids.data, job.lists.ids.size),
                            vulkan::reads(job.lists.ranges.data, job.lists.ranges.size),
                            vulkan::writes(job.to, std::size_t(job.pitch) * std::size_t(job.height)),
                            std::uint32_t(job.x), std::uint32_t(job.y), std::uint32_t(job.width),
                            std::uint32_t(job.height), std::uint32_t(job.pitch)),
               vulkan::Commands::Shape::of(std::size_t(job.width) * std::size_t(job.height)));
  commands.submit();
}

FrameCounted count_frame(const Vulkan& b, const RasterJob& job, CountRasterBlock count) {
  return count_on_host(b, job, count);
}

}  // namespace swiftgs
