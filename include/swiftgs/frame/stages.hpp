// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/sort.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/tiles.hpp>

/// @file
/// The stages of a frame on one backend: project, shade, bin, sort, gather, rasterize. A policy enters as a
/// function or object that is bound to it at run time, so all combinations of policies share these classes.
/// `<swiftgs/functor/stage_table.hpp>` makes the functions of policies.

namespace swiftgs {

struct FrameCounted;
template <class B>
struct ProjectScratch;

/// The stages that depend on bounds.
template <class B>
struct BoundsStages {
  std::string_view name;
  bool conservative;
  void (*project)(B&, const FramePlan&, ProjectScratch<B>&, Splats<B>&, Footprints<B>&);
  void (*bin)(B&, const FramePlan&, Splats<B>&, Footprints<B>&);
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
};

/// Stages that no policy chooses.
template <class B>
struct CommonStages {
  /// Evaluates the colours of splats, maybe beside what follows until `Shading::finish`.
  Shading<B> (*shade)(B&, const FramePlan&, const Splats<B>&, Colours<B>&);
  /// What the last `project` and `bin` found. Waits for it on a device.
  FrameReport (*report)(B&, Splats<B>&, Footprints<B>&, const Limits&);
  /// Writes the attributes of a pass, @shape{splats, rows}.
  void (*gather)(B&, const FramePlan&, const SplatsView&, const RasterPass&, AttributeRow*);
};

/// How backend `B` runs the stages of a frame.
template <class B>
struct StageTable {
  BoundsStages<B> bounds;
  RasterStage<B> raster;
  CommonStages<B> common;
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

/// What a driver adds to a frame.
class FrameHooks {
 public:
  /// Called before the first stage with 0, after `bin` with 1, after the sort with 2, and at the end with 3.
  virtual void mark(std::size_t) {}
  /// Called between sort and rasterization, which alone reads occluders and the image below. A host does not
  /// call it for a frame above its capacity.
  virtual void before_raster(RasterJob&) {}
  /// Called when the lists of `job` were rasterized, with the attributes of the first pass.
  virtual void after_raster(const RasterJob&) {}

 protected:
  ~FrameHooks() = default;
};

/// Hooks that do nothing.
struct NoHooks final : FrameHooks {};

/// Runs the stages of a frame, in the only place where their order stands, and owns the memory between them.
template <class B>
class Stages {
 public:
  Stages(B backend, const StageTable<B>& table, std::unique_ptr<SortStage<B>> sort)
      : backend_(std::move(backend)), table_(table), sort_(std::move(sort)) {
    std::apply([&](auto&... parts) { use_memory_of(backend_, parts...); }, parts());
    sort_->use_memory(backend_);
  }

  B& backend() { return backend_; }
  const B& backend() const { return backend_; }
  const StageTable<B>& table() const { return table_; }
  SortStage<B>& sort() { return *sort_; }

  /// Starts all stages. A host leaves sort and rasterization out if the frame does not fit the limits of its
  /// plan.
  void run(const FramePlan& plan, FrameHooks& hooks) {
    run(plan, true, hooks, [&](RasterJob& job) {
      rows_.reset(plan.passes.kept_rows() * job.splats.size());
      if (plan.passes.size() > 1) gather(plan, job, {.rows = 1}, kept_row(job));
      for (std::size_t k = 0; k < plan.passes.size(); ++k) rasterize(plan, plan.passes[k], job);
    });
  }

  /// The same with `use(job)` in place of rasterization. Without `shaded`, no colours are evaluated.
  template <class Use>
  void run(const FramePlan& plan, bool shaded, FrameHooks& hooks, const Use& use) {
    hooks.mark(0);
    project(plan);
    std::optional<Shading<B>> shading;
    // void: nvcc takes the reference that emplace returns for a discarded `Shading`.
    if (shaded) (void)shading.emplace(table_.common.shade(backend_, plan, splats_, colours_));
    const auto colours = [&] { return shading ? shading->finish() : ColoursView{}; };
    run_behind(plan, splats_, footprints_, colours, hooks, use);
  }

  /// The first stage alone.
  void project(const FramePlan& plan) {
    table_.bounds.project(backend_, plan, project_scratch_, splats_, footprints_);
  }

  /// The stages after `shade`, of the caller's splats. Asks for `colours()` after the sort.
  template <class Colours, class Use>
  void run_behind(const FramePlan& plan, Splats<B>& splats, Footprints<B>& footprints, const Colours& colours,
                  FrameHooks& hooks, const Use& use) {
    table_.bounds.bin(backend_, plan, splats, footprints);
    hooks.mark(1);
    if constexpr (B::reaches_host_memory)
      if (table_.common.report(backend_, splats, footprints, plan.limits).overflowed != 0) return;

    sort_->build(backend_, {splats.view(), footprints.view(), plan.key(), plan.use()}, lists_);
    hooks.mark(2);
    RasterJob job{.splats = splats.view(), .colours = colours(), .lists = lists_.view(), .views = plan.views};
    hooks.before_raster(job);
    use(job);
    hooks.after_raster(job);
    hooks.mark(3);
  }

  /// Numbers of splats and intersections of the last frame. Waits for them on a device.
  FrameReport report(const FramePlan& plan) {
    return table_.common.report(backend_, splats_, footprints_, plan.limits);
  }
  /// Sets the intersections of a frame that `report` told the host about.
  void set_intersections(std::uint64_t intersections) { lists_.intersections = std::size_t(intersections); }

  /// Takes the memory of such frames, on hosts.
  void reserve(const Reservation& reserved, const RasterPasses& passes) {
    std::apply([&](auto&... parts) { reserve_parts(backend_, reserved, parts...); }, parts());
    if (passes.kept_rows() != 0) rows_.reset_exactly(passes.kept_rows() * reserved.capacity.splats);
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
            .sort = sort_->bytes() + bytes_of(lists_),
            .raster = bytes_of(rows_)};
  }

  /// The last frame's splats, footprints, tile lists and, if it had any, colours.
  Splats<B>& splats() { return splats_; }
  const Splats<B>& splats() const { return splats_; }
  Footprints<B>& footprints() { return footprints_; }
  const TileLists<B>& lists() const { return lists_; }
  Span<const SplatColour> colours() const { return {colours_.each.data(), splats_.count}; }
  const FrameTiles& tiles() const { return footprints_.views.tiles; }

 private:
  auto parts() { return std::tie(project_scratch_, splats_, footprints_, colours_, lists_, rows_); }

  /// Where the first row of each splat lies if a frame has several passes.
  AttributeRow* kept_row(const RasterJob& job) {
    return rows_.data() + AttributesView::most_rows * job.splats.size();
  }
  void gather(const FramePlan& plan, const RasterJob& job, const RasterPass& pass, AttributeRow* to) {
    table_.common.gather(backend_, plan, job.splats, pass, to);
  }

  /// Leaves the attributes of the base pass in `base`.
  void rasterize(const FramePlan& plan, const RasterPass& pass, RasterJob& base) {
    RasterJob job = base;
    job.only_attributes = !pass.is_base;
    if (!pass.is_base) job.counts = nullptr;
    if (pass.rows != 0) {
      const bool kept = plan.passes.size() > 1;
      job.attributes = {.data = rows_.data(),
                        .rows = pass.rows,
                        .first = pass.first,
                        .first_row = kept ? kept_row(job) : rows_.data(),
                        .first_stride = kept ? 1 : pass.rows};
      gather(plan, job, pass, rows_.data());
    }
    table_.raster.rasterize(backend_, job);
    if (pass.is_base) base = job;
  }

  B backend_;
  StageTable<B> table_;
  std::unique_ptr<SortStage<B>> sort_;
  ProjectScratch<B> project_scratch_;
  Splats<B> splats_;
  Footprints<B> footprints_;
  Colours<B> colours_;
  TileLists<B> lists_;
  typename B::template Buffer<AttributeRow> rows_;  ///< of the passes of a frame
};

}  // namespace swiftgs
