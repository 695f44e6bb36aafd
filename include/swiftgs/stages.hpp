// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include <swiftgs/backend.hpp>
#include <swiftgs/bin_stage.hpp>
#include <swiftgs/bounds/bounds.hpp>
#include <swiftgs/colours.hpp>
#include <swiftgs/footprint.hpp>
#include <swiftgs/frame_plan.hpp>
#include <swiftgs/hidden_intersections.hpp>
#include <swiftgs/project_stage.hpp>
#include <swiftgs/raster/raster.hpp>
#include <swiftgs/shade_stage.hpp>
#include <swiftgs/sort/sort.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/statistics.hpp>
#include <swiftgs/tiles.hpp>

/// @file
/// The five stages of a frame on one backend: project, shade, bin, sort, rasterize. A policy enters as one
/// function or object that is bound to it at run time, so all combinations of policies share these classes.

namespace swiftgs {

namespace detail {
// Overloads of a backend are found where these are instantiated.
template <class Bounds, class B>
void project_within(B& b, const FramePlan& plan, ProjectScratch<B>& scratch, Splats<B>& splats,
                    Footprints<B>& footprints) {
  project(b, plan, Bounds{}, scratch, splats, footprints);
}
template <class Bounds, class B>
void bin_within(B& b, const FramePlan& plan, Splats<B>& splats, Footprints<B>& footprints) {
  bin(b, plan, Bounds{}, splats, footprints);
}
template <class R, class B>
void rasterize_by(B& b, const RasterJob& job) {
  rasterize(b, R{}, job);
}
template <class R, class B>
FrameCounted count_by(B& b, const RasterJob& job) {
  if constexpr (B::reaches_host_memory) {
    FrameCounted counted{.intersections_hidden = count_hidden(job)};
    const std::size_t blocks = raster_blocks_of(job).size();
    for (std::size_t block = 0; block < blocks; ++block) counted.raster += job.counts[block];
    return counted;
  } else if constexpr (requires { count_frame(b, R{}, job); }) {
    return count_frame(b, R{}, job);
  } else {
    return {};
  }
}
}  // namespace detail

/// The stages that depend on bounds.
template <class B>
struct BoundsStages {
  std::string_view name;
  bool conservative;
  void (*project)(B&, const FramePlan&, ProjectScratch<B>&, Splats<B>&, Footprints<B>&);
  void (*bin)(B&, const FramePlan&, Splats<B>&, Footprints<B>&);

  template <BoundsPolicy Bounds>
  static BoundsStages of() {
    return {Bounds::name, Bounds::conservative, &detail::project_within<Bounds, B>,
            &detail::bin_within<Bounds, B>};
  }
};

/// Policy `R` rasterizes on backend `B`, by its own kernel or by an overload that the backend offers.
template <class R, class B>
concept RastersOn = BackendPolicy<B> && requires(B& b, R raster, const RasterJob& job) {
  { R::name } -> std::convertible_to<std::string_view>;
  rasterize(b, raster, job);
};

/// The stage that depends on the rasterizer.
template <class B>
struct RasterStage {
  std::string_view name;
  bool may_gain_by_coarse_tiles;
  void (*rasterize)(B&, const RasterJob&);
  /// What a job took that was rasterized: with `counts` on hosts, while a device's lists are blended anew on
  /// the host by `R::Kernel`. Waits.
  FrameCounted (*count)(B&, const RasterJob&);

  template <RastersOn<B> R>
  static RasterStage of() {
    return {R::name, swiftgs::may_gain_by_coarse_tiles<B, R>, &detail::rasterize_by<R, B>,
            &detail::count_by<R, B>};
  }
};

/// A sort within bounds, and the memory that it works in.
template <class B>
class SortStage {
 public:
  virtual ~SortStage() = default;
  virtual void build(B& b, const SortJob& job, TileLists<B>& lists) = 0;
  /// False while an adaptive sort still measures frames.
  virtual bool decided() const = 0;
  virtual std::size_t bytes() const = 0;
  /// As `use_memory_of`, `reserve_parts` and `trim_parts`.
  virtual void use_memory(const B& b) = 0;
  virtual void reserve(B& b, const Reservation& reserved) = 0;
  virtual void trim(const B& b) = 0;
};

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

/// Runs the stages of a frame, in the only place where their order stands, and owns the memory between them.
template <class B>
class Stages {
 public:
  Stages(B backend, const BoundsStages<B>& bounds, std::unique_ptr<SortStage<B>> sort)
      : backend_(std::move(backend)), bounds_(bounds), sort_(std::move(sort)) {
    std::apply([&](auto&... parts) { use_memory_of(backend_, parts...); }, parts());
    sort_->use_memory(backend_);
  }

  B& backend() { return backend_; }
  const B& backend() const { return backend_; }
  SortStage<B>& sort() { return *sort_; }
  bool conservative() const { return bounds_.conservative; }

  /// Starts all stages; the last is `rasterize(job)`. Calls mark(k) before the first, k = 0, after `bin`,
  /// after the sort, and at the end. A host leaves sort and rasterization out if the frame does not fit the
  /// limits of its plan. Without `shaded`, no colours are evaluated.
  template <class Rasterize, class Mark>
  void run(const FramePlan& plan, bool shaded, const Rasterize& rasterize, const Mark& mark) {
    mark(0);
    project(plan);
    std::optional<Shading<B>> shading;
    // void: nvcc takes the reference that emplace returns for a discarded `Shading`.
    if (shaded) (void)shading.emplace(shade(backend_, plan, splats_, colours_));
    const auto colours = [&] { return shading ? shading->finish() : ColoursView{}; };
    draw(plan, splats_, footprints_, colours, rasterize, mark);
  }

  /// The first stage alone.
  void project(const FramePlan& plan) {
    bounds_.project(backend_, plan, project_scratch_, splats_, footprints_);
  }

  /// The stages after `shade`, of the caller's splats. Asks for `colours()` after the sort.
  template <class Colours, class Rasterize, class Mark>
  void draw(const FramePlan& plan, Splats<B>& splats, Footprints<B>& footprints, const Colours& colours,
            const Rasterize& rasterize, const Mark& mark) {
    bounds_.bin(backend_, plan, splats, footprints);
    mark(1);
    if constexpr (B::reaches_host_memory)
      if (await_report(backend_, splats, footprints, plan.limits).overflowed != 0) return;

    sort_->build(backend_, {splats.view(), footprints.view(), plan.key(), plan.use()}, lists_);
    mark(2);
    rasterize(RasterJob{
        .splats = splats.view(), .colours = colours(), .lists = lists_.view(), .views = plan.views});
    mark(3);
  }

  /// Numbers of splats and intersections of the last frame. Waits for them on a device.
  FrameReport report(const FramePlan& plan) {
    return await_report(backend_, splats_, footprints_, plan.limits);
  }
  /// Sets the intersections of a frame that `report` told the host about.
  void set_intersections(std::uint64_t intersections) { lists_.intersections = std::size_t(intersections); }

  /// Takes the memory of such frames, on hosts.
  void reserve(const Reservation& reserved) {
    std::apply([&](auto&... parts) { reserve_parts(backend_, reserved, parts...); }, parts());
    sort_->reserve(backend_, reserved);
  }
  /// Gives all memory back.
  void trim() {
    std::apply([&](auto&... parts) { trim_parts(backend_, parts...); }, parts());
    sort_->trim(backend_);
  }
  /// @units{bytes}
  StageMemory memory() const {
    return {.project = bytes_of(project_scratch_, splats_, footprints_, colours_),
            .sort = sort_->bytes() + bytes_of(lists_)};
  }

  /// The last frame's splats, footprints, tile lists and, if it had any, colours.
  Splats<B>& splats() { return splats_; }
  const Splats<B>& splats() const { return splats_; }
  Footprints<B>& footprints() { return footprints_; }
  const TileLists<B>& lists() const { return lists_; }
  Span<const SplatColour> colours() const { return {colours_.each.data(), splats_.count}; }
  const FrameTiles& tiles() const { return footprints_.views.tiles; }

 private:
  auto parts() { return std::tie(project_scratch_, splats_, footprints_, colours_, lists_); }

  B backend_;
  BoundsStages<B> bounds_;
  std::unique_ptr<SortStage<B>> sort_;
  ProjectScratch<B> project_scratch_;
  Splats<B> splats_;
  Footprints<B> footprints_;
  Colours<B> colours_;
  TileLists<B> lists_;
};

}  // namespace swiftgs
