// SPDX-License-Identifier: Apache-2.0

// Projection, colours, and the numbers of a frame.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/vulkan/stages.hpp>

#include "commands.hpp"
#include "seen.hpp"

namespace swiftgs {

namespace vulkan {
namespace {

/// Workgroups of projection that have the Gaussians of placed scenes, view by view.
template <class F>
std::size_t for_each_part(const FramePlan& plan, const F& f) {
  std::size_t workgroups = 0;
  const Span<const StoredScene> all = plan.scenes.each();
  for (std::size_t v = 0; v < plan.views.size(); ++v)
    for (const StoredScene& placed : plan.scenes.shown(plan.views[v])) {
      f(v, std::size_t(&placed - all.data), placed, workgroups);
      workgroups += (placed.size() + usual_threads - 1) / usual_threads;
    }
  return workgroups;
}

}  // namespace

void project(Vulkan& b, const FramePlan& plan, BoundsKind bounds, ProjectScratch<Vulkan>& scratch,
             Splats<Vulkan>& splats, Footprints<Vulkan>& footprints) {
  const std::size_t candidates = plan.candidates(), views = plan.views.size();
  if (candidates > 0xffffffff - usual_threads)
    throw CapacityError("Gaussians in all views", candidates, 0xffffffff - usual_threads);
  const std::size_t capacity =
      plan.limits.capacity.splats == 0 ? candidates : std::min(plan.limits.capacity.splats, candidates);
  const std::size_t workgroups = for_each_part(plan, [](auto&&...) {});
  scratch.projected.reset(workgroups * usual_threads), scratch.places.reset(workgroups + 1);
  scratch.tile_counts.reset(2 * workgroups);
  splats.reset(capacity, views), footprints.each.reset(capacity);
  splats.count = capacity, splats.exact = scratch.places.data() + workgroups;

  Commands commands(b);
  commands.reserve_scan(workgroups + 1);
  const Seen* const seen = all_seen(commands, plan.views, plan.scenes);
  const TileGrid* const grids = grids_of(commands, plan.views);
  const std::size_t scenes = plan.scenes.size();
  std::uint32_t* const places = scratch.places.data();
  commands.fill(places + workgroups, 1, 0);
  if (views > 1) commands.fill(splats.of_view.data(), (capacity + 1) / 2, 0);
  for_each_part(plan, [&](std::size_t v, std::size_t s, const StoredScene& placed, std::size_t first) {
    const std::size_t n = placed.size();
    Projected* const projected = scratch.projected.data() + first * usual_threads;
    const ViewConstants& camera = plan.views[v].camera;
    commands.run(camera.through_lens ? Kernel::project_lens : Kernel::project, {Eye::lens_of(camera)},
                 Push(seen + v * scenes + s, projected, places + first, std::uint32_t(n)),
                 Commands::Shape::of(n),
                 {writes(projected, n * sizeof(Projected)),
                  writes(places + first, 4 * ((n + usual_threads - 1) / usual_threads))});
  });
  commands.scan(places, workgroups + 1);
  for_each_part(plan, [&](std::size_t v, std::size_t, const StoredScene& placed, std::size_t first) {
    const std::size_t n = placed.size();
    const Projected* const projected = scratch.projected.data() + first * usual_threads;
    std::uint32_t* const tiles = scratch.tile_counts.data() + 2 * first;
    const std::uint16_t* const of_view = views > 1 ? splats.of_view.data() : nullptr;
    // Parts write to places of their own, and to words of `of_view` by atomics: no barrier between them.
    commands.run(Kernel::compact, {bounds.number},
                 Push(projected, places + first, splats.shapes.data(), splats.depths.data(),
                      splats.gaussians.data(), of_view, footprints.each.data(), tiles, grids + v,
                      std::uint32_t(n), std::uint32_t(capacity), placed.first_gaussian, std::uint32_t(v)),
                 Commands::Shape::of(n),
                 {reads(projected, n * sizeof(Projected)), reads(places, 4 * (workgroups + 1)),
                  writes(tiles, 8 * ((n + usual_threads - 1) / usual_threads))});
  });
  commands.submit();
  footprints.found = {scratch.tile_counts.data(), std::uint32_t(workgroups)};
  footprints.found_within = bounds.name;
}

namespace {
/// Finds the footprints of splats that projection did not bin within these bounds.
void find_footprints(Commands& commands, const FramePlan& plan, BoundsKind bounds,
                     const Splats<Vulkan>& splats, Footprints<Vulkan>& footprints) {
  const std::size_t n = splats.count;
  const SplatsView view = splats.view();
  footprints.found = {footprints.tile_counts.data(), std::uint32_t((n + usual_threads - 1) / usual_threads)};
  commands.run(Kernel::footprints, {bounds.number},
               Push(view.shapes.data, view.of_view, grids_of(commands, plan.views), footprints.each.data(),
                    footprints.tile_counts.data(), view.count()),
               Commands::Shape::of(n),
               {writes(footprints.each.data(), n * sizeof(Footprint)),
                writes(footprints.tile_counts.data(), 8 * footprints.found.workgroups)});
}
}  // namespace

void bin(Vulkan& b, const FramePlan& plan, BoundsKind bounds, Splats<Vulkan>& splats,
         Footprints<Vulkan>& footprints) {
  const Limits& limits = plan.limits;
  const bool by_projection = footprints.found.counts && footprints.found_within == bounds.name;
  if (!by_projection) {
    footprints.each.reset(splats.count);
    footprints.tile_counts.reset(2 * ((splats.count + usual_threads - 1) / usual_threads));
  }
  footprints.totals.reset(1);
  FrameTotals* const totals = footprints.totals.data();

  Commands commands(b);
  if (!by_projection) find_footprints(commands, plan, bounds, splats, footprints);
  const TileCounts& found = footprints.found;
  // All that are visible, also beyond the capacity.
  const Count visible = splats.exact ? Count(0xffffffff, splats.exact) : Count(splats.count);
  Vulkan::State& state = b.state();
  const void* const report = limits.report ? static_cast<const void*>(limits.report) : state.report.device;
  commands.run(Kernel::settle, {},
               Push(found.counts, totals, report, visible, found.workgroups,
                    std::uint32_t(std::min<std::size_t>(limits.capacity.splats, 0xffffffff)),
                    std::uint32_t(limits.capacity.intersections), std::uint32_t(limits.draw)),
               {1},
               {reads(found.counts, 8 * found.workgroups), writes(totals, sizeof(FrameTotals)),
                writes(report, sizeof(FrameReport))});
  commands.release_to_host();
  const std::uint64_t value = commands.submit();
  if (!limits.report) state.reported_at = value;

  footprints.found = {}, footprints.views = plan.views;
  footprints.count = splats.count, splats.exact = &totals->splats;
  footprints.intersections = Count(limits.capacity.intersections, &totals->intersections);
  footprints.overflowed = &totals->report.overflowed;
  if (limits.capacity.intersections != 0) return;
  FrameReport known;
  b.download(Span<const FrameReport>{&totals->report, 1}, &known);
  check_intersections(known.intersections);
  footprints.intersections = known.overflowed != 0 ? 0 : std::size_t(known.intersections);
}

}  // namespace vulkan

FrameReport await_report(Vulkan& b, Splats<Vulkan>& splats, Footprints<Vulkan>& footprints, const Limits&) {
  Vulkan::State& state = b.state();
  vulkan::refuse_while_recording(state, "await_report");
  state.device.state().wait(state.reported_at);
  FrameReport report;
  std::memcpy(&report, state.report.host, sizeof report);
  if (report.overflowed) return report;
  splats.count = footprints.count = std::size_t(report.visible), splats.exact = nullptr;
  footprints.intersections = std::size_t(report.intersections), footprints.overflowed = nullptr;
  return report;
}

Shading<Vulkan> shade(Vulkan& b, const FramePlan& plan, const Splats<Vulkan>& splats,
                      Colours<Vulkan>& colours) {
  const std::size_t n = splats.count;
  colours.each.reset(n), colours.hidden.reset(1);
  vulkan::Commands commands(b);
  commands.fill(colours.hidden.data(), 1, 0);
  const SplatsView view = splats.view();
  commands.run(vulkan::Kernel::shade, {},
               vulkan::Push(vulkan::all_seen(commands, plan.views, plan.scenes), view.shapes.data,
                            view.gaussians.data, view.of_view, view.depths.data, colours.each.data(),
                            colours.hidden.data(), view.count(), std::uint32_t(plan.scenes.size())),
               vulkan::Commands::Shape::of(n),
               {vulkan::writes(colours.each.data(), n * sizeof(SplatColour)),
                vulkan::writes(colours.hidden.data(), 4)});
  commands.submit();
  return Shading<Vulkan>({{colours.each.data(), n}, colours.hidden.data()});
}

void gather_attributes(Vulkan& b, const SplatAttributes& from, const StoredScenes& scenes, const Views& views,
                       AttributeRow* to) {
  const SplatsView& splats = from.splats;
  vulkan::Commands commands(b);
  std::vector<vulkan::AttributeList> lists;
  for (const View& view : views) lists.emplace_back(view, from.first, from.rows);
  commands.run(from.along_ray(views.each) ? vulkan::Kernel::attributes_ray : vulkan::Kernel::attributes, {},
               vulkan::Push(vulkan::all_seen(commands, views, scenes), splats.shapes.data,
                            splats.gaussians.data, splats.of_view, splats.depths.data,
                            commands.constants(Span<const vulkan::AttributeList>{lists.data(), lists.size()}),
                            to, splats.count(), std::uint32_t(scenes.size())),
               vulkan::Commands::Shape::of(splats.size()),
               {vulkan::writes(to, splats.size() * from.rows * sizeof(AttributeRow))});
  commands.submit();
}

}  // namespace swiftgs
