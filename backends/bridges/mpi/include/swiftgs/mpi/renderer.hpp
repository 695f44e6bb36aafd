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

#include <swiftgs/drivers/render_settings.hpp>
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
#include <swiftgs/renderer.hpp>

namespace swiftgs {

/// Renders frames of placed scenes whose parts lie on the ranks. Each rank projects its own Gaussians,
/// sends splats to the ranks whose strips they touch, and draws its own strip by the stages of `Renderer`.
/// The bits are those of one `Renderer` that draws the same parts rank by rank.
///
/// Part r of a scene holds Gaussians that follow those of part r - 1 in the order of the scene (`part_of`).
/// With several placed scenes each rank gives its parts of all, placed alike: Gaussians are numbered rank by
/// rank, and of equal depths the lower rank's is in front. All functions that render are collective, and all
/// ranks ask for the same planes of the same views; the orders and colours that these leave to the scenes
/// must agree. If one rank fails, all throw: that rank its own error, the others `RankError`; the renderers
/// stay usable. After an `MpiError` the program must end.
template <class B, class Sort = EarlySort, class Raster = AxisSharedThreshold<FloatCholesky>,
          class Bounds = Ellipse>
requires(detail::check_policies<B, Sort, Raster, Bounds>()) class DistributedRenderer {
 public:
  /// As of `Renderer`.
  static constexpr std::string_view name = Renderer<B, Sort, Raster, Bounds>::name;

  /// Collective. Throws `InvalidArgument` on all ranks if their builds of the program, or their
  /// renderers, differ, and `MpiError` if devices cannot be joined, after which the program has to end.
  explicit DistributedRenderer(Ranks ranks, B backend = B(), Sort sort = Sort())
      : ranks_(std::move(ranks)), one_(std::move(backend), std::move(sort)) {
    std::apply([&](auto&... all) { use_memory_of(this->backend(), all...); }, parts(*this));
    ranks_.require_same("the build of the program", build_identity());
    ranks_.require_same("the renderer", std::string(name));
    if (ranks_.size() > most_ranks)
      detail::refuse("ranks: their number is ", ranks_.size(), ", expected 65535 at most");
    link_ = direct_link(ranks_, this->backend());
    exchange_.set_ranks(ranks_, bool(link_));
  }

  const Ranks& ranks() const { return ranks_; }
  B& backend() { return one_.backend(); }
  const B& backend() const { return one_.backend(); }
  /// What brings splats from rank to rank: "host", which is MPI, or the name of a `DirectLink`.
  std::string_view carrier() const { return link_ ? link_->name() : "host"; }

  /// Renders into this rank's memory for whole views, which its backend reaches. Reads and writes only the
  /// pixels of its strip, see `drawn`. Finished when it returns. Throws as `Renderer::render_into`, and
  /// `RankError`.
  void render_into(const PlacedScenes& part, Span<const View> views) {
    Failure failure;
    failure.guard([&] {
      for (const View& view : views) validate(view);
    });
    const auto place = [&] {
      for (DrawnStrip& each : drawn_)
        each.frame = each.view_strip.pixels_of(views[each.view_strip.view].frame);
    };
    draw(part, views, failure, place, [] {});
  }

  /// Renders a view a camera into memory of the backend that the renderer keeps until the next call, each
  /// rank its strip. Returns and throws as `render_into`.
  Span<const DrawnStrip> render_strips(const PlacedScenes& part, Span<const Camera> cameras,
                                       const RenderSettings& settings) {
    Failure failure;
    failure.guard([&] { make_views(part, cameras, settings); });
    const auto place = [&] { frames_.keep(backend(), settings.outputs, drawn_); };
    draw(part, {views_.data(), views_.size()}, failure, place, [] {});
    return drawn();
  }

  /// Renders a frame a camera and collects them on rank 0, on the host. `frames` has as many there, and is
  /// not looked at on other ranks. Throws as `render_into`.
  void render(const PlacedScenes& part, Span<const Camera> cameras, const RenderSettings& settings,
              Span<Frame> frames) {
    const bool collects = ranks_.rank() == 0;
    std::vector<FrameView> whole;
    Failure failure;
    failure.guard([&] {
      make_views(part, cameras, settings);
      if (collects && frames.size != cameras.size)
        detail::refuse("render: the number of frames is ", frames.size, ", expected ", cameras.size,
                       ", one a camera");
      for (std::size_t i = 0; collects && i < frames.size; ++i)
        whole.push_back(prepare(frames[i], cameras[i].width, cameras[i].height, settings.outputs));
    });
    const auto place = [&] {
      if (B::reaches_host_memory && collects)
        for (DrawnStrip& each : drawn_) each.frame = each.view_strip.pixels_of(whole[each.view_strip.view]);
      else
        frames_.keep(backend(), settings.outputs, drawn_);
      if (collects) frames_.expect(strips_, frames);
    };
    draw(part, {views_.data(), views_.size()}, failure, place,
         [&] { frames_.to_host(backend(), ranks_, drawn_, frames); });
    frames_.collect(ranks_, strips_);
  }
  void render(const PlacedScenes& part, const Camera& camera, const RenderSettings& settings, Frame& frame) {
    render(part, {&camera, 1}, settings, {&frame, 1});
  }

  /// Strips of the last frame that this rank has drawn: none if the ranks outnumber the rows of tiles.
  Span<const DrawnStrip> drawn() const { return {drawn_.data(), drawn_.size()}; }

  /// Counters of all ranks for the last frame; the same on all ranks. Empty if the frame failed.
  const FrameCounters& counters() const { return counters_; }

  /// Memory that this rank's stages and exchange take of the backend's. @units{bytes}
  std::size_t memory() const {
    return std::apply([](const auto&... all) { return bytes_of(all...); }, parts(*this)) +
           one_.memory().total();
  }

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

  void make_views(const PlacedScenes& part, Span<const Camera> cameras, const RenderSettings& settings) {
    swiftgs::make_views(cameras, settings, views_);
    require_features(part, settings.outputs.features);  // before memory is taken for them
  }

  /// One frame. `place` gives the view strips of `drawn_` memory; `finish` is called when they are drawn.
  template <class Place, class Finish>
  void draw(const PlacedScenes& part, Span<const View> views, Failure& failure, const Place& place,
            const Finish& finish) {
    drawn_.clear(), counters_ = {};
    try {
      if (ranks_.size() == 1)
        draw_alone(part, views, failure, place, finish);
      else
        draw_together(part, views, failure, place, finish);
    } catch (...) {
      shares_.forget_capacity();
      drawn_.clear();
      throw;
    }
  }

  template <class Place, class Finish>
  void draw_together(const PlacedScenes& part, Span<const View> views, Failure& failure, const Place& place,
                     const Finish& finish) {
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
      place();
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
      shading.emplace(one_.stages().table().common.shade(backend(), *whole, shares_.splats, colours_));
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
    learn(mine, failure);
  }

  /// Draws the frame on a rank alone, whose strip is the whole frame.
  template <class Place, class Finish>
  void draw_alone(const PlacedScenes& scene, Span<const View> views, const Failure& failure,
                  const Place& place, const Finish& finish) {
    failure.agree(ranks_);
    const Clock::time_point begun = Clock::now();
    std::vector<View> all(views.begin(), views.end());
    for (const View& view : views)
      drawn_.push_back(
          {{.view = std::uint32_t(drawn_.size()), .rows = view.frame.height, .width = view.frame.width}});
    place();
    for (std::size_t i = 0; i < all.size(); ++i) all[i].frame = drawn_[i].frame;
    one_.render_into(scene, {all.data(), all.size()}, {.count = false, .time = true});
    backend().wait();
    finish();
    const Statistics found = one_.statistics();
    const StageTimes times = one_.times();
    RankCounters mine{.gaussians = found.gaussians, .visible = found.visible, .drawn = found.visible};
    mine.intersections = found.intersections, mine.rows = one_.tiles().rows, mine.bytes = memory();
    mine.project_ns = std::uint64_t(1e6 * times.project);
    mine.strip_ns = std::uint64_t(1e6 * (times.sort + times.raster)), mine.frame_ns = since(begun);
    counters_ = {{mine}};
  }

  /// Finds the splats of this rank's Gaussians in all views, and shares them out among the ranks. Returns the
  /// plan of these views.
  FramePlan project_part(const PlacedScenes& part, Span<const View> views, RankCounters& mine) {
    FramePlan plan =
        plan_frame(backend(), part, views, plan_memory_, [&](const StoredScenes&, Span<const View> cut) {
          return tiles_.choose(FrameKey::of({}, cut), cut, one_.may_gain_by_coarse_tiles());
        });
    mine.gaussians = plan.scenes.gaussians();
    const std::uint32_t rows = plan.views.tiles.rows;
    if (!strip_plan_ || strip_plan_->rows() != rows) strip_plan_.emplace(rows, ranks_.size());
    const FrameReport report = whole_capacity_.draw_until_it_fits([&](const Capacity& capacity) {
      // As many intersections as there may be: strips have their own, and these are not emitted.
      if (!B::reaches_host_memory) plan.limits = {{capacity.splats, std::size_t(max_intersections)}};
      Stages<B>& stages = one_.stages();
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
      one_.stages().table().common.gather(backend(), plan, shares_.splats.view(), pass,
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
      one_.stages().run_behind(plan, splats, strip_footprints_, arriving_colours, points,
                               [&](RasterJob& job) {
                                 job.attributes = attributes;
                                 one_.stages().table().raster.rasterize(backend(), job);
                                 drawn = job;
                               });
      shapes.wait(), colours.wait();  // sees faults of a link, which work that waits for messages would not
      return one_.stages().table().common.report(backend(), splats, strip_footprints_, plan.limits);
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
      one_.stages().table().raster.rasterize(backend(), *drawn);
      const auto end = backend().now();
      backend().wait();
      mine.strip_ns += ns(begun, end);
    });
  }

  /// Ends the frame on all ranks, and learns from their times.
  void learn(RankCounters mine, const Failure& failure) {
    mine.failed = bool(failure);
    FrameCounters counters{ranks_.all_gather(mine)};
    std::vector<std::uint64_t> taken;
    for (const RankCounters& rank : counters.ranks) {
      if (rank.failed != 0) failure.tell(ranks_);
      taken.push_back(rank.strip_ns);
    }
    counters_ = std::move(counters);
    tiles_.learn(counters_.visible());
    strip_plan_->learn({taken.data(), taken.size()});
    complete_ = true;
  }

  Ranks ranks_;
  Renderer<B, Sort, Raster, Bounds> one_;  ///< draws for a rank alone; has the stages
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
  std::vector<View> views_;    ///< of cameras
  std::vector<Strip> strips_;  ///< of all ranks
  std::vector<Offer> offers_;  ///< from each rank
  std::vector<DrawnStrip> drawn_;
  FrameCounters counters_;
  FrameCapacity whole_capacity_, strip_capacity_;  ///< of a device's projection, and of its strip
  bool complete_ = false;                          ///< whether all ranks drew the last frame
};

}  // namespace swiftgs
