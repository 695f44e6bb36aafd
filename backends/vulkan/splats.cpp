// SPDX-License-Identifier: Apache-2.0

// Projection, colours, and the numbers of a frame.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>
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
  for (std::size_t v = 0; v < plan.views.size(); ++v)
    for (const StoredScene& placed : plan.scenes.shown(plan.views[v])) {
      f(v, placed, workgroups);
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
  footprints.found_within = {};
  Commands commands(b);
  b.state().counted = {};
  scratch.shapes.reset(workgroups * usual_threads), scratch.projected.reset(workgroups * usual_threads);
  const std::size_t most_counts = (workgroups + 3) / 4 * 4, runs = workgroups / run_size + 1;
  scratch.counts.reset(most_counts), scratch.runs.reset(runs);
  splats.reset(capacity, views), footprints.each.reset(capacity), footprints.totals.reset(1);
  FrameTotals* const totals = footprints.totals.data();
  commands.fill(scratch.runs.data(), runs, 0);
  commands.fill(words_at(totals), sizeof *totals / sizeof(std::uint32_t), 0);
  splats.count = capacity, splats.exact = words_at(&totals->report.visible);

  const TileGrid* const grids = grids_of(commands, plan.views);
  std::uint32_t* const counts = scratch.counts.data();
  std::uint32_t* const view_words = views > 1 ? words_at(splats.of_view.data()) : nullptr;
  if (view_words) commands.fill(view_words, (capacity + 1) / 2, 0);
  for_each_part(plan, [&](std::size_t v, const StoredScene& placed, std::size_t first) {
    const std::size_t n = placed.size();
    const ViewConstants& camera = plan.views[v].camera;
    commands.run(
        camera.through_lens ? Kernel::project_lens : Kernel::project, {Eye::lens_of(camera)},
        Push(commands.uniform(Seen(plan.views[v], placed)),
             writes(scratch.shapes.data() + first * usual_threads, n),
             writes(scratch.projected.data() + first * usual_threads, n), shares(counts, most_counts),
             shares(scratch.runs.data(), runs), shares(totals, 1), std::uint32_t(n), std::uint32_t(first)),
        Commands::Shape::of(n));
  });
  for_each_part(plan, [&](std::size_t v, const StoredScene& placed, std::size_t first) {
    const std::size_t n = placed.size();
    commands.run({Kernel::compact, bounds, &BoundsShaders::compact}, {bounds.number},
                 Push(reads(scratch.shapes.data() + first * usual_threads, n),
                      reads(scratch.projected.data() + first * usual_threads, n), reads(counts, most_counts),
                      reads(scratch.runs.data(), runs), shares(splats.shapes.data(), capacity),
                      shares(splats.depths.data(), capacity), shares(splats.gaussians.data(), capacity),
                      shares(view_words, (capacity + 1) / 2), shares(footprints.each.data(), capacity),
                      shares(totals, 1), address(grids + v), std::uint32_t(n), std::uint32_t(capacity),
                      placed.first_gaussian, std::uint32_t(first), std::uint32_t(v)),
                 Commands::Shape::of(n));
  });
  commands.finish();
  footprints.found_within = bounds.name;
}

namespace {
Access reads_views(const SplatsView& splats) { return reads(splats.of_view, splats.size()); }

/// Finds the footprints of splats that projection did not bin within these bounds.
void find_footprints(Commands& commands, const FramePlan& plan, BoundsKind bounds,
                     const Splats<Vulkan>& splats, Footprints<Vulkan>& footprints) {
  const std::size_t n = splats.count;
  FrameTotals* const totals = footprints.totals.data();
  footprints.each.reset(n);
  commands.fill(words_at(&totals->report.intersections), 2, 0);
  const SplatsView view = splats.view();
  commands.run({Kernel::footprints, bounds, &BoundsShaders::footprints}, {bounds.number},
               Push(reads(view.shapes.data, n), reads_views(view), address(grids_of(commands, plan.views)),
                    writes(footprints.each.data(), n), shares(totals, 1), view.count()),
               Commands::Shape::of(n));
}

/// Gives the host the counts of a frame, unless it overflowed.
void tell(const FrameReport& report, Splats<Vulkan>& splats, Footprints<Vulkan>& footprints) {
  if (report.overflowed != 0) return;
  splats.count = footprints.count = std::size_t(report.visible), splats.exact = nullptr;
  footprints.intersections = std::size_t(report.intersections), footprints.overflowed = nullptr;
}
}  // namespace

void bin(Vulkan& b, const FramePlan& plan, BoundsKind bounds, Splats<Vulkan>& splats,
         Footprints<Vulkan>& footprints) {
  const Limits& limits = plan.limits;
  Commands commands(b);
  footprints.totals.reset(1);
  if (footprints.found_within != bounds.name) find_footprints(commands, plan, bounds, splats, footprints);
  FrameTotals* const totals = footprints.totals.data();
  // All that are visible, also beyond the capacity.
  const Count visible = splats.exact ? Count(0xffffffff, splats.exact) : Count(splats.count);
  Vulkan::State& state = b.state();
  const void* const report = limits.report ? static_cast<const void*>(limits.report) : state.report.device;
  commands.run(Kernel::settle, {},
               Push(writes(totals, 1), writes(static_cast<const FrameReport*>(report), 1),
                    writes(state.groups.device, Vulkan::State::long_launch), visible,
                    std::uint32_t(std::min<std::size_t>(limits.capacity.splats, 0xffffffff)),
                    std::uint32_t(limits.capacity.intersections), std::uint32_t(limits.draw),
                    commands.sort_part(splats.count), commands.sort_part(limits.capacity.intersections)),
               {.columns = 1, .threads = commands.subgroup()});
  // The device projects while the host records what comes behind, and the host goes on when it has projected.
  const std::uint64_t value = commands.submit();
  state.awaited = !limits.report;
  if (state.awaited) state.reported_at = value;

  footprints.found_within = {}, footprints.views = plan.views;
  footprints.count = splats.count, splats.exact = &totals->splats;
  footprints.intersections = Count(limits.capacity.intersections, &totals->intersections);
  footprints.overflowed = &totals->report.overflowed;
  state.counted = {Count(splats.count, splats.exact), footprints.intersections};
  if (limits.capacity.intersections != 0) return;
  FrameReport known;
  b.download(Span<const FrameReport>{&totals->report, 1}, &known);
  check_intersections(known.intersections);
  tell(known, splats, footprints);
  if (known.overflowed != 0) footprints.intersections = 0;
}

}  // namespace vulkan

FrameReport await_report(Vulkan& b, Splats<Vulkan>& splats, Footprints<Vulkan>& footprints, const Limits&) {
  Vulkan::State& state = b.state();
  vulkan::refuse_while_recording(state, "await_report");
  state.awaited = false;
  if (state.open) vulkan::Commands(b).submit();
  state.device.state().wait(state.reported_at);
  FrameReport report;
  std::memcpy(&report, state.report.host, sizeof report);
  vulkan::tell(report, splats, footprints);
  return report;
}

Shading<Vulkan> shade(Vulkan& b, const FramePlan& plan, const Splats<Vulkan>& splats,
                      Colours<Vulkan>& colours) {
  const SplatsView view = splats.view();
  const std::size_t n = view.size();
  colours.each.reset(n), colours.colourless.reset(1);
  SplatColour* const to = colours.each.data();
  std::uint32_t* const colourless = colours.colourless.data();
  vulkan::Commands(b).fill(colourless, 1, 0);
  // A launch beside each pass of the sort, which leaves most of the memory's rate idle.
  constexpr std::size_t least = 1 << 18, most_launches = 5;
  const std::size_t launches = std::clamp<std::size_t>(n / least, 1, most_launches);
  const std::size_t each = ((n + launches - 1) / launches + vulkan::usual_threads - 1) /
                           vulkan::usual_threads * vulkan::usual_threads;
  // Copied once for all launches in the same command buffer.
  struct Copied {
    std::optional<std::size_t> slot;
    const vulkan::Seen* seen = nullptr;
  };
  const auto copied = std::make_shared<Copied>();
  for (std::size_t first = 0; first < n; first += each)
    b.state().beside.emplace_back([=, &b, &plan](vulkan::Commands& commands) {
      const std::size_t slot = b.state().next_slot;
      if (copied->slot != slot) *copied = {slot, vulkan::all_seen(commands, plan.views, plan.scenes)};
      commands.run(vulkan::Kernel::shade, {},
                   vulkan::Push(vulkan::address(copied->seen), vulkan::reads(view.gaussians.data, n),
                                vulkan::reads_views(view), vulkan::reads(view.depths.data, n),
                                vulkan::shares(to, n), vulkan::shares(colourless, 1), view.count(),
                                std::uint32_t(plan.scenes.size()), std::uint32_t(first)),
                   vulkan::Commands::Shape::of(std::min(each, n - first)));
    });
  return Shading<Vulkan>(b, {{to, n}, colourless});
}

ColoursView Shading<Vulkan>::finish() {
  vulkan::Commands commands(*b_);
  while (commands.run_beside()) continue;
  commands.finish();
  b_ = nullptr;  // after what may throw: the destructor drops launches that are left
  return colours_;
}

Shading<Vulkan>::~Shading() {
  if (b_) b_->state().beside.clear();
}

void gather_attributes(Vulkan& b, const SplatAttributes& from, const StoredScenes& scenes, const Views& views,
                       AttributeRow* to) {
  const SplatsView& splats = from.splats;
  const std::size_t n = splats.size();
  vulkan::Commands commands(b);
  std::vector<vulkan::AttributeList> lists;
  for (const View& view : views) lists.emplace_back(view, from.first, from.rows);
  commands.run(
      from.along_ray(views.each) ? vulkan::Kernel::attributes_ray : vulkan::Kernel::attributes, {},
      vulkan::Push(
          vulkan::address(vulkan::all_seen(commands, views, scenes)), vulkan::reads(splats.shapes.data, n),
          vulkan::reads(splats.gaussians.data, n), vulkan::reads_views(splats),
          vulkan::reads(splats.depths.data, n),
          vulkan::address(commands.constants(Span<const vulkan::AttributeList>{lists.data(), lists.size()})),
          vulkan::writes(to, n * from.rows), splats.count(), std::uint32_t(scenes.size())),
      commands.over(splats.count()));
  commands.finish();
}

}  // namespace swiftgs
