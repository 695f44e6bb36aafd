// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The functions that run the stages of policies on a backend, found among the overloads of that backend.

#include <concepts>
#include <cstddef>
#include <string_view>
#include <utility>

#include <swiftgs/drivers/statistics.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/stages.hpp>
#include <swiftgs/functor/blend.hpp>
#include <swiftgs/functor/bounds_stages.hpp>
#include <swiftgs/functor/shade_stage.hpp>
#include <swiftgs/functor/sort_stages.hpp>
#include <swiftgs/plane/attribute_stage.hpp>

namespace swiftgs {

/// The stages of `Bounds` on backend `B`.
template <class B, BoundsPolicy Bounds>
BoundsStages<B> bounds_stages() {
  return {
      .name = Bounds::name,
      .conservative = Bounds::conservative,
      .project = [](B& b, const FramePlan& plan, ProjectScratch<B>& scratch, Splats<B>& splats,
                    Footprints<B>& footprints) { project(b, plan, Bounds{}, scratch, splats, footprints); },
      .bin = [](B& b, const FramePlan& plan, Splats<B>& splats,
                Footprints<B>& footprints) { bin(b, plan, Bounds{}, splats, footprints); }};
}

/// Policy `R` rasterizes on backend `B`, by its own kernel or by an overload that the backend offers.
template <class R, class B>
concept RastersOn = BackendPolicy<B> && requires(B& b, R raster, const RasterJob& job) {
  { R::name } -> std::convertible_to<std::string_view>;
  rasterize(b, raster, job);
};

namespace detail {
template <class R, class B>
FrameCounted count_by(B& b, const RasterJob& job) {
  if constexpr (B::reaches_host_memory) {
    FrameCounted counted{.intersections_hidden = count_hidden(job)};
    const std::size_t blocks = raster_blocks_of(job).size();
    for (std::size_t block = 0; block < blocks; ++block) counted.raster += job.counts[block];
    return counted;
  } else if constexpr (RasterPolicy<R> && requires { count_frame(b, job, CountRasterBlock()); }) {
    return count_frame(b, job, [](const RasterJob& on_host, const RasterBlocks& blocks, std::size_t block) {
      BlendRasterBlock<R>{on_host, blocks}(block);
    });
  } else {
    return {};
  }
}
}  // namespace detail

/// The stage of rasterizer `R` on backend `B`.
template <class B, RastersOn<B> R>
RasterStage<B> raster_stage() {
  return {.name = R::name,
          .may_gain_by_coarse_tiles = may_gain_by_coarse_tiles<B, R>,
          .rasterize = [](B& b, const RasterJob& job) { rasterize(b, R{}, job); },
          .count = &detail::count_by<R, B>};
}

/// The stages of backend `B` that no policy chooses.
template <class B>
CommonStages<B> common_stages() {
  return {.shade = [](B& b, const FramePlan& plan, const Splats<B>& splats,
                      Colours<B>& colours) { return shade(b, plan, splats, colours); },
          .report = [](B& b, Splats<B>& splats, Footprints<B>& footprints,
                       const Limits& limits) { return await_report(b, splats, footprints, limits); },
          .gather =
              [](B& b, const FramePlan& plan, const SplatsView& splats, const RasterPass& pass,
                 AttributeRow* to) {
                gather_attributes(b, {splats, pass.first, pass.rows}, plan.scenes, plan.views, to);
              }};
}

template <class B, RastersOn<B> R, BoundsPolicy Bounds>
StageTable<B> stage_table() {
  return {bounds_stages<B, Bounds>(), raster_stage<B, R>(), common_stages<B>()};
}

/// The sort stage of policy `Sort`.
template <class B, class Sort, class Bounds>
class SortStageOf final : public SortStage<B> {
 public:
  explicit SortStageOf(Sort policy = Sort()) : sort(std::move(policy)) {}
  void build(B& b, const SortJob& job, TileLists<B>& lists) override {
    sort.build(b, job, Bounds{}, scratch_, lists);
  }
  bool decided() const override {
    if constexpr (requires { sort.measured().has_value(); })
      return sort.measured().has_value();
    else
      return true;
  }
  std::size_t bytes() const override { return bytes_of(scratch_); }
  void use_memory(const B& b) override { use_memory_of(b, scratch_); }
  void reserve(B& b, const Reservation& reserved) override { reserve_parts(b, reserved, scratch_); }
  void trim(const B& b) override { trim_parts(b, scratch_); }

  Sort sort;

 private:
  typename Sort::template Scratch<B> scratch_;
};

}  // namespace swiftgs
