// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What every backend is asked for on hard frames.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/raster/all.hpp>
#include <swiftgs/renderer.hpp>
#include <swiftgs/sort/early.hpp>
#include <swiftgs/sort/standard.hpp>

#include "hard_frames/families.hpp"
#include "stability/case_judge.hpp"

namespace swiftgs::test {

/// Largest normalised error of colour and transmittance, and of depth.
inline constexpr double normalised_error_gate = 10;

inline RenderSettings settings_of(const StressCase& drawn) {
  return {.conventions = drawn.conventions, .background = drawn.background, .outputs = {true, true}};
}

/// Draws on backends that work in the host's memory.
struct DrawOnHost {
  template <class R>
  Frame operator()(R& renderer, const StressCase& drawn) const {
    Frame frame;
    FrameView view = prepare(frame, drawn.camera.width, drawn.camera.height, {true, true});
    if (!drawn.occluder.empty())
      view.occluder = {drawn.occluder.data(), std::ptrdiff_t(sizeof(float)) * frame.width};
    // As a caller's own arrays, which nothing looks at before.
    const PlacedScene placed{swiftgs::view(drawn.scene), drawn.world_from_scene, 1, drawn.clip};
    renderer.render_into(Span<const PlacedScene>{&placed, 1}, drawn.camera, settings_of(drawn), view);
    return frame;
  }
};

/// Bounds that list every splat for every tile.
struct WholeImage {
  static constexpr std::string_view name = "whole-image";
  static constexpr bool conservative = true;

  BoxTiles tiles(const SplatShape&, TileGrid grid) const { return {{grid.columns, grid.rows}}; }
};

/// Which renderers draw a case.
enum class Extent {
  rasterizers,  ///< each rasterizer with one sort and one bounds
  all           ///< other sorts and bounds as well, whose bits must be equal
};

/// What is asked of colours beside their normalised error: a mean hides the worst value.
struct Limits {
  double least_db = -INFINITY, most_abs = INFINITY;
  double most_normalised_error = normalised_error_gate;
  // Of rasterizers whose exponent representation is allowed no error of its own.
  double least_judged = 0;  ///< share of pixels
  double most_flips = 1;    ///< share of pixels
};

/// Limits of a family: the judge may excuse little of it but where that is what the family is about.
inline Limits limits_of(std::string_view family, double severity) {
  Limits limits{.least_judged = 1, .most_flips = 0.005};
  // All splats have an alpha of alpha_min.
  if (family == "on-alphas") limits.least_judged = 0, limits.most_flips = 1;
  // The light behind a stop, or before it.
  if (family == "on-stops") limits.most_flips = 1;
  // A unit in the last place of a mean is a part of a pixel that shows, a pixel, or more.
  if (family == "distant-means" && severity >= 1e6) limits.most_flips = 0.02;
  if (family == "principal-points" && severity >= 1e7) limits.least_judged = 0, limits.most_flips = 1;
  if (family == "world-offsets" && severity >= 1e6) limits.least_judged = 0.99;
  return limits;
}

/// Renderers of one backend, kept from case to case as a program keeps its own.
template <class B, class Draw = DrawOnHost>
class Sweep {
 public:
  explicit Sweep(Draw draw = {}) : draw_(draw) {}

  /// Draws the case of `judge` with every rasterizer.
  void check(CaseJudge& judge, Extent extent, Limits limits = {}) {
    std::apply([&](auto&... pair) { (check_pair(pair, judge, extent, limits), ...); }, pairs_);
    if (extent != Extent::all) return;
    const Frame first = draw_(std::get<Pair<Usual>>(pairs_).first, judge.drawn());
    CHECK(same_planes(draw_(standard_ellipse_, judge.drawn()), first));
    check_within(judge.drawn(), first);
  }

  /// Draws with bounds that leave nothing out too: conservative bounds must leave out nothing either.
  void check_bounds(const StressCase& drawn) {
    const auto check = [&](auto& pair, auto& whole) {
      const Frame expected = draw_(whole, drawn);
      CHECK(same_planes(draw_(pair.first, drawn), expected));
      CHECK(same_planes(draw_(pair.second, drawn), expected));
      return expected;
    };
    check_within(drawn, check(std::get<Pair<Usual>>(pairs_), whole_));
    check(std::get<Pair<PerPixel>>(pairs_), whole_per_pixel_);
  }

  /// f(name, frame) for each rasterizer whose exponent is 0 at the mean of a splat, with both pairs of sort
  /// and bounds.
  template <class F>
  void for_each_frame(const StressCase& drawn, const F& f) {
    const auto give = [&](auto& pair) {
      f(pair.first.name, draw_(pair.first, drawn)), f(pair.second.name, draw_(pair.second, drawn));
    };
    give(std::get<Pair<Usual>>(pairs_)), give(std::get<Pair<PerPixel>>(pairs_));
    give(std::get<Pair<AxisShared<FloatCholesky>>>(pairs_));
  }

  /// What each rasterizer draws.
  std::vector<Frame> frames(const StressCase& drawn) {
    return std::apply([&](auto&... pair) { return std::vector<Frame>{draw_(pair.first, drawn)...}; }, pairs_);
  }

  /// Splats of the case as they are projected.
  std::vector<SplatShape> shapes(const StressCase& drawn) {
    auto& renderer = std::get<Pair<Usual>>(pairs_).first;
    draw_(renderer, drawn);
    const Span<const SplatShape> projected = renderer.splats().view().shapes;
    std::vector<SplatShape> out(projected.size);
    renderer.backend().download(projected, out.data());
    return out;
  }

  /// Draws with squares of three sigmas a case whose footprint they are.
  void check_square(CaseJudge& judge) {
    const auto check = [&](auto& renderer) {
      check_frame(draw_(renderer, judge.drawn()), renderer.name, judge, {});
    };
    check(square_half_), check(square_split_), check(square_per_pixel_);
  }

 private:
  using Usual = AxisSharedThreshold<FloatCholesky>;
  template <class Raster>
  struct Pair {
    Renderer<B, EarlySort, Raster, Ellipse> first;
    Renderer<B, StandardSort, Raster, OpacityBox> second;
  };

  template <class... Rasters>
  static std::tuple<Pair<Rasters>...> pairs_of(TypeList<Rasters...>);

  /// A renderer within each of the library's bounds.
  template <class... Bounds>
  static std::tuple<Renderer<B, EarlySort, Usual, Bounds>...> renderers_within(TypeList<Bounds...>);
  using Within = decltype(renderers_within(AllBounds()));

  /// Whether all conservative bounds draw the same frame.
  void check_within(const StressCase& drawn, const Frame& expected) {
    const auto check = [&]<class Bounds>(Renderer<B, EarlySort, Usual, Bounds>& renderer) {
      CAPTURE(Bounds::name);
      if constexpr (Bounds::conservative) CHECK(same_planes(draw_(renderer, drawn), expected));
    };
    std::apply([&](auto&... renderer) { (check(renderer), ...); }, within_);
  }

  template <class P>
  void check_pair(P& pair, CaseJudge& judge, Extent extent, Limits limits) {
    const std::string_view name = pair.first.name;
    CAPTURE(name);
    const Frame frame = draw_(pair.first, judge.drawn());
    check_frame(frame, name, judge, limits);
    if (extent == Extent::all) CHECK(same_planes(draw_(pair.second, judge.drawn()), frame));
  }

  static void check_frame(const Frame& frame, std::string_view name, CaseJudge& judge, Limits limits) {
    CAPTURE(name);
    CHECK(is_finite(frame));
    const StressVerdict verdict = judge.judge(name, frame);
    CHECK(verdict.normalised_error <= limits.most_normalised_error);
    CHECK(verdict.normalised_depth_error <= limits.most_normalised_error);
    if (name.find("half") == std::string_view::npos) {
      CHECK(verdict.psnr_db >= limits.least_db);
      CHECK(verdict.max_abs <= limits.most_abs);
    }
    if (name.find("split") == std::string_view::npos) {
      CHECK(verdict.judged >= limits.least_judged);
      const std::size_t pixels = std::size_t(frame.width) * std::size_t(frame.height);
      CHECK(double(verdict.flips) <= limits.most_flips * double(pixels));
    }
  }

  Draw draw_;
  decltype(pairs_of(AllRasters())) pairs_;
  Renderer<B, StandardSort, Usual, Ellipse> standard_ellipse_;
  Within within_;
  // Devices run bounds of the caller's only where nvcc compiles them.
  using Whole = std::conditional_t<bool(B::reaches_host_memory), WholeImage, OpacityBox>;
  Renderer<B, EarlySort, Usual, Whole> whole_;
  Renderer<B, EarlySort, PerPixel, Whole> whole_per_pixel_;
  Renderer<B, EarlySort, AxisSharedThreshold<HalfSplit>, ThreeSigmaSquare> square_half_;
  Renderer<B, EarlySort, AxisShared<FloatSplit>, ThreeSigmaSquare> square_split_;
  Renderer<B, StandardSort, PerPixel, ThreeSigmaSquare> square_per_pixel_;
};

/// Calls f(case, limits) with every severity of the families that are named, and of all where none is.
template <class F>
void for_each_case(const std::vector<std::string_view>& names, const std::vector<std::uint64_t>& seeds,
                   ImageSize size, const F& f) {
  for (const StressFamily& family : stress_families()) {
    if (!names.empty() && std::find(names.begin(), names.end(), family.name) == names.end()) continue;
    for (const double severity : family.severities)
      for (const std::uint64_t seed : seeds) {
        CAPTURE(family.name);
        CAPTURE(severity);
        CAPTURE(seed);
        CAPTURE(size.width);
        CAPTURE(size.height);
        f(family.make(severity, seed, size), limits_of(family.name, severity));
      }
  }
}

}  // namespace swiftgs::test
