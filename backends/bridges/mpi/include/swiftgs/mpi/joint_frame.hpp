// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <swiftgs/drivers/bound_renderer.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/learnt.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/mpi/counters.hpp>
#include <swiftgs/mpi/direct_link.hpp>
#include <swiftgs/mpi/identity.hpp>
#include <swiftgs/mpi/offers.hpp>
#include <swiftgs/mpi/ranks.hpp>
#include <swiftgs/mpi/shares.hpp>
#include <swiftgs/mpi/splat_exchange.hpp>
#include <swiftgs/mpi/strip_frames.hpp>
#include <swiftgs/mpi/strips.hpp>

namespace swiftgs {

/// A frame that several ranks draw together, and its memory on this rank. Each rank projects its own
/// Gaussians, sends splats to the ranks whose strips they touch, and draws its own strip by the stages of a
/// renderer.
template <class B, class Bounds>
class JointFrame {
 public:
  /// Collective. `one` has these bounds. Throws as the constructor of `DistributedRenderer`.
  JointFrame(Ranks ranks, std::unique_ptr<BoundRenderer<B>> one)
      : ranks_(std::move(ranks)), one_(std::move(one)) {
    std::apply([&](auto&... all) { use_memory_of(backend(), all...); }, parts(*this));
    ranks_.require_same("the build of the program", build_identity());
    ranks_.require_same("the renderer", std::string(one_->name()));
    if (ranks_.size() > most_ranks)
      detail::refuse("ranks: their number is ", ranks_.size(), ", expected 65535 at most");
    link_ = direct_link(ranks_, backend());
    exchange_.set_ranks(ranks_, bool(link_));
  }

  const Ranks& ranks() const { return ranks_; }
  /// Has the stages; draws for a rank alone.
  BoundRenderer<B>& one() { return *one_; }
  const BoundRenderer<B>& one() const { return *one_; }
  B& backend() { return one_->backend(); }
  std::string_view carrier() const { return link_ ? link_->name() : "host"; }

  /// Strips of all ranks, of the last frame.
  const std::vector<Strip>& strips() const { return strips_; }
  /// The strips that this rank draws. A frame that fails empties them.
  std::vector<DrawnStrip>& drawn() { return drawn_; }
  const std::vector<DrawnStrip>& drawn() const { return drawn_; }
  StripFrames<B>& frames() { return frames_; }

  /// Memory on this rank. @units{bytes}
  std::size_t memory() const {
    return std::apply([](const auto&... all) { return bytes_of(all...); }, parts(*this)) +
           one_->memory().total();
  }

  /// Draws this rank's strip and returns the counters of all ranks. Collective. `provide` gives memory to
  /// what `drawn` names, before it is drawn, and `finish` is called behind it. Throws as
  /// `DistributedRenderer::render_into`.
  template <class Provide, class Finish>
  FrameCounters draw(const PlacedScenes& part, Span<const View> views, Failure& failure,
                     const Provide& provide, const Finish& finish) {
    const Clock::time_point begun = Clock::now();
    const Traffic before = ranks_.traffic();
    RankCounters mine;
    // Ranks that failed apart from each other may have learnt different costs.
    if (!complete_) strip_plan_.reset(), tiles_ = {};
    complete_ = false;
    std::optional<FramePlan> whole;
    failure.guard([&] { whole = project_part(part, views, mine); });
    mine.project_ns = since(begun);
    const bool indices = std::any_of(views.begin(), views.end(), [](const View& view) {
      const Request asked = view.asked();
      return asked.id || asked.median_id;
    });
    exchange_offers(ranks_, shares_,
                    {.gaussians = indices ? std::uint32_t(mine.gaussians) : 0,
                     .frame = views_identity(whole ? whole->views.each : views)},
                    failure, offers_);
    failure.guard([&] {
      prepare_strips(*whole, views);
      provide();
    });
    failure.agree(ranks_);

    // Colours are evaluated while shapes are under way, and are under way while those are sorted. Not sooner:
    // a device that is full of their evaluation would start to send when it is done. The first attributes go
    // with them, and are found before, so that what waits for colours finds both.
    Exchange shapes(ranks_, link_.get()), colours(ranks_, link_.get());
    std::optional<Shading<B>> shading;
    failure.guard([&] { exchange_.stage_shapes(backend(), shares_.splats.view()); });
    exchange_.send_shapes(shapes, strips_);
    failure.guard([&] {
      find_attributes(*whole, whole->passes[0]);
      shading.emplace(one_->stages().table().common.shade(backend(), *whole, shares_.splats, colours_));
      exchange_.keep_shapes(backend(), shares_.splats.view());
    });
    if (!link_) {
      shapes.wait();  // MPI goes on in its own calls alone
      failure.guard([&] {
        shading->finish(), exchange_.stage_colours(backend());
        exchange_.stage_attributes(backend(), whole->passes[0]);
      });
    }
    exchange_.send_colours(colours), exchange_.send_attributes(colours, whole->passes[0]);
    bool begun_colours = false;
    const auto begin_colours = [&] {
      if (!std::exchange(begun_colours, true)) colours.begin(link_ && shading ? shading->stream() : nullptr);
    };
    std::optional<RasterJob> drawn;
    failure.guard([&] { drawn = draw_strip(*whole, shapes, begin_colours, *shading, colours, mine); });
    begin_colours();  // where the strip has failed or shows nothing
    shapes.wait(), colours.wait();
    for (std::size_t k = 1; k < whole->passes.size(); ++k)
      draw_attributes(*whole, whole->passes[k], drawn, failure, mine);
    failure.guard(finish);
    mine.frame_ns = since(begun);
    mine.traffic = ranks_.traffic() - before;
    return learn(mine, failure);
  }

  /// After a frame that failed: the next asks for no more memory than it needs.
  void forget() { shares_.forget_capacity(), drawn_.clear(); }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr int most_ranks = 65535;

  static auto parts(auto& self) {
    return std::tie(self.plan_memory_, self.shares_, self.colours_, self.exchange_, self.strip_storage_,
                    self.strip_footprints_, self.frames_);
  }

  /// Points on the backend's clock between stages.
  struct Points final : FrameHooks {
    explicit Points(B& of) : b(of) {}
    void mark(std::size_t point) override { each[point] = b.now(); }

    B& b;
    std::array<typename B::TimePoint, 4> each{};
  };

  static std::uint64_t since(Clock::time_point begun) {
    return std::uint64_t(std::chrono::nanoseconds(Clock::now() - begun).count());
  }
  std::uint64_t ns(const typename B::TimePoint& from, const typename B::TimePoint& to) {
    return std::uint64_t(1e6 * backend().milliseconds(from, to).value_or(0));
  }

  /// Finds the splats of this rank's Gaussians in all views, and shares them out among the ranks. Returns the
  /// plan of these views.
  FramePlan project_part(const PlacedScenes& part, Span<const View> views, RankCounters& mine) {
    FramePlan plan =
        plan_frame(backend(), part, views, plan_memory_, [&](const StoredScenes&, Span<const View> cut) {
          return tiles_.choose(FrameKey::of({}, cut), cut, one_->may_gain_by_coarse_tiles());
        });
    mine.gaussians = plan.scenes.gaussians();
    const std::uint32_t rows = plan.views.tiles.rows;
    if (!strip_plan_ || strip_plan_->rows() != rows) strip_plan_.emplace(rows, ranks_.size());
    const FrameReport report = whole_capacity_.draw_until_it_fits([&](const Capacity& capacity) {
      // As many intersections as there may be: strips have their own, and these are not emitted.
      if (!B::reaches_host_memory) plan.limits = {{capacity.splats, std::size_t(max_intersections)}};
      Stages<B>& stages = one_->stages();
      stages.project(plan);
      share_out(backend(), plan, Bounds{}, strip_plan_->cuts(), stages.splats(), stages.footprints(),
                shares_);
      return await_shares(backend(), shares_);
    });
    mine.visible = report.visible;
    const auto own = ranks_.rank();
    mine.sent = shares_.begins.back() - shares_.count_for(own);
    mine.first_row = strip_plan_->cuts()[std::size_t(own)];
    mine.rows = strip_plan_->cuts()[std::size_t(own) + 1] - mine.first_row;
    return plan;
  }

  /// Whoever asked for `views` knows nothing of parts.
  void prepare_strips(const FramePlan& plan, Span<const View> views) {
    const StripCuts& cuts = strip_plan_->cuts();
    strips_.clear();
    for (std::size_t r = 0; r + 1 < cuts.size(); ++r)
      strips_.push_back(strip_of(plan.views.each, cuts[r], cuts[r + 1]));
    for (Strip& strip : strips_)
      for (ViewStrip& view_strip : strip.view_strips) {
        const View& part = plan.views[view_strip.view];
        view_strip.view = owner_of(plan_memory_.planned.owners(), view_strip.view);
        view_strip.first_column = part.left() - views[view_strip.view].left();
      }
    exchange_.prepare_strips(backend(), strips_, shares_, colours_, {offers_.data(), offers_.size()},
                             plan.passes);
    for (const ViewStrip& view_strip : strips_[std::size_t(ranks_.rank())].view_strips)
      drawn_.push_back({view_strip});
  }

  /// Finds the attributes of a pass for the splats that this rank shares.
  void find_attributes(const FramePlan& plan, const RasterPass& pass) {
    if (pass.rows != 0)
      one_->stages().table().common.gather(backend(), plan, shares_.splats.view(), pass,
                                           exchange_.attribute_rows());
  }

  /// Bins, sorts and rasterizes the splats of this rank's strip, with the first attributes. Its time counts
  /// this work alone: no messages, and only the last time where a strip is drawn again with more capacity.
  /// Returns the job that it rasterized; none if the strip shows nothing.
  template <class BeginColours>
  std::optional<RasterJob> draw_strip(const FramePlan& whole, Exchange& shapes,
                                      const BeginColours& begin_colours, Shading<B>& shading,
                                      Exchange& colours, RankCounters& mine) {
    Strip& strip = strips_[std::size_t(ranks_.rank())];
    Splats<B>& splats = exchange_.joined();
    mine.drawn = splats.count, mine.bytes = memory();
    if (strip.views.empty()) return {};
    for (std::size_t i = 0; i < strip.views.size(); ++i) {
      FrameView& frame = strip.views[i].frame;
      const Conversion conversion = frame.conversion;  // as the scene's model has it
      frame = drawn_[i].frame, frame.conversion = conversion;
    }
    const Views stored = store_views(backend(), {strip.views.data(), strip.views.size()}, strip_storage_);
    shapes.join();
    exchange_.shapes_arrived(backend(), strip);
    bool arrived = false;
    AttributesView attributes;
    Points points(backend());
    typename B::TimePoint begun_raster{};
    const auto arriving_colours = [&] {
      if (!std::exchange(arrived, true)) {
        begin_colours();  // the host has had time for it since the sort began
        shading.finish();
        colours.join();
        exchange_.colours_arrived(backend(), colours_);
        attributes = exchange_.attributes_arrived(backend(), whole.passes[0]);
      }
      begun_raster = backend().now();
      return exchange_.colours();
    };
    FramePlan plan(stored, whole.scenes);
    std::optional<RasterJob> drawn;
    const FrameReport report = strip_capacity_.draw_until_it_fits([&](const Capacity& capacity) {
      splats.set_count(std::size_t(mine.drawn));
      if (!B::reaches_host_memory) plan.limits = {{0, capacity.intersections}};
      points.mark(0);
      one_->stages().run_behind(plan, splats, strip_footprints_, arriving_colours, points,
                                [&](RasterJob& job) {
                                  job.attributes = attributes;
                                  one_->stages().table().raster.rasterize(backend(), job);
                                  drawn = job;
                                });
      shapes.wait(), colours.wait();  // sees faults of a link, which work that waits for messages would not
      return one_->stages().table().common.report(backend(), splats, strip_footprints_, plan.limits);
    });
    mine.intersections = report.intersections;
    backend().wait();
    mine.strip_ns = ns(points.each[0], points.each[2]) + ns(begun_raster, points.each[3]);
    mine.bytes = memory();
    return drawn;
  }

  /// Draws a later pass over the tile lists of `drawn`. Ranks that show nothing or have failed take part too,
  /// because others wait for their attributes.
  void draw_attributes(const FramePlan& whole, const RasterPass& pass, std::optional<RasterJob>& drawn,
                       Failure& failure, RankCounters& mine) {
    failure.guard([&] {
      find_attributes(whole, pass);
      exchange_.stage_attributes(backend(), pass);
    });
    Exchange attributes(ranks_, link_.get());
    exchange_.send_attributes(attributes, pass);
    attributes.begin();
    attributes.wait();
    failure.guard([&] {
      if (!drawn) return;
      drawn->attributes = exchange_.attributes_arrived(backend(), pass), drawn->only_attributes = true;
      const auto begun = backend().now();
      one_->stages().table().raster.rasterize(backend(), *drawn);
      const auto end = backend().now();
      backend().wait();
      mine.strip_ns += ns(begun, end);
    });
  }

  /// Ends the frame on all ranks, and learns from their times. Returns their counters.
  FrameCounters learn(RankCounters mine, const Failure& failure) {
    mine.failed = bool(failure);
    FrameCounters counters{ranks_.all_gather(mine)};
    std::vector<std::uint64_t> taken;
    for (const RankCounters& rank : counters.ranks) {
      if (rank.failed != 0) failure.tell(ranks_);
      taken.push_back(rank.strip_ns);
    }
    tiles_.learn(counters.visible());
    strip_plan_->learn({taken.data(), taken.size()});
    complete_ = true;
    return counters;
  }

  Ranks ranks_;
  std::unique_ptr<BoundRenderer<B>> one_;
  std::unique_ptr<DirectLink> link_;
  PlanMemory<B> plan_memory_;  ///< of whole views, and of this rank's part
  ViewStorage<B> strip_storage_;
  Footprints<B> strip_footprints_;
  Shares<B> shares_;
  Colours<B> colours_;  ///< of the shares
  SplatExchange<B> exchange_;
  StripFrames<B> frames_;
  std::optional<StripPlan> strip_plan_;
  TileChoice tiles_;           ///< by the views alone
  std::vector<Strip> strips_;  ///< of all ranks
  std::vector<Offer> offers_;  ///< from each rank
  std::vector<DrawnStrip> drawn_;
  FrameCapacity whole_capacity_, strip_capacity_;  ///< of a device's projection, and of its strip
  bool complete_ = false;                          ///< whether all ranks drew the last frame
};

}  // namespace swiftgs
