// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include <swiftgs/bounds/ellipse.hpp>
#include <swiftgs/drivers/bound_renderer.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/sort.hpp>
#include <swiftgs/frame/stages.hpp>
#include <swiftgs/functor/stage_table.hpp>
#include <swiftgs/raster/axis_shared.hpp>
#include <swiftgs/sort/early.hpp>
#include <swiftgs/tools/policy_lists.hpp>

namespace swiftgs::detail {

template <class P>
concept Named = requires {
  { P::name } -> std::convertible_to<std::string_view>;
};

template <class R>
concept StartsRows = requires(typename R::Kernel kernel) {
  kernel.start_row(0.0f);
};
template <class R>
concept HasFloatAlpha = requires(typename R::Kernel kernel) {
  { kernel.alpha(0) } -> std::same_as<float>;
};
template <class S, class B>
concept HasScratch = requires {
  typename S::template Scratch<B>;
};
template <class Bounds>
concept HasRows = requires(const Bounds bounds, const SplatShape& shape, TileGrid grid) {
  { bounds.tiles(shape, grid).rect } -> std::convertible_to<TileRect>;
  { bounds.tiles(shape, grid).row(0) } -> std::same_as<TileRun>;
};

/// Does not compile if a policy lacks a member; the error names the member. Compilers print this text before
/// their own account of an unsatisfied concept.
template <class B, class Sort, class Raster, class Bounds>
constexpr bool check_policies() {
  static_assert(BackendPolicy<B>, "backend: expected the members that the comment of BackendPolicy lists");

  static_assert(Named<Bounds>, "bounds: expected `static constexpr std::string_view name`");
  static_assert(
      HasRows<Bounds>,
      "bounds: expected `tiles(const SplatShape&, TileGrid) const` whose result has `TileRect rect` and "
      "`TileRun row(int) const`");
  static_assert(!Named<Bounds> || !HasRows<Bounds> || BoundsPolicy<Bounds>,
                "bounds: expected `static constexpr bool conservative`");

  static_assert(Named<Sort>, "sort: expected `static constexpr std::string_view name`");
  static_assert(HasScratch<Sort, B>,
                "sort: expected `template <class B> struct Scratch`, the memory it works in");
  if constexpr (HasScratch<Sort, B>) {
    static_assert(
        HasBytes<typename Sort::template Scratch<B>>,
        "sort: expected Scratch with `static auto buffers(auto& self)` or `std::size_t bytes() const`");
    static_assert(std::default_initializable<typename Sort::template Scratch<B>> &&
                      std::movable<typename Sort::template Scratch<B>>,
                  "sort: expected Scratch that can be made empty and moved");
    if constexpr (BackendPolicy<B> && BoundsPolicy<Bounds>)
      static_assert(SortsOn<Sort, B, Bounds>,
                    "sort: expected `build(B&, const SortJob&, const Bounds&, Scratch<B>&, TileLists<B>&)`");
  }

  static_assert(Named<Raster>, "rasterizer: expected `static constexpr std::string_view name`");
  constexpr bool rasters = RastersOn<Raster, B>;
  if constexpr (!rasters)
    static_assert(
        FunctorBackend<B>,
        "backend: expected the members that the comment of FunctorBackend lists, or stages of its own");
  static_assert(
      rasters || requires { typename Raster::Kernel; },
      "rasterizer: expected a type `Kernel`, or a function rasterize(B&, Raster, const RasterJob&)");
  if constexpr (requires { typename Raster::Kernel; }) {
    static_assert(
        rasters || std::constructible_from<typename Raster::Kernel, const SplatShape&, vec2, BlendRules>,
        "rasterizer: expected `Kernel(const SplatShape&, vec2 first_centre, BlendRules)`");
    static_assert(rasters || StartsRows<Raster>, "rasterizer: expected `void Kernel::start_row(float y)`");
    static_assert(rasters || HasFloatAlpha<Raster>,
                  "rasterizer: expected `Kernel::alpha(int column)` that returns a float");
  }
  return true;
}

}  // namespace swiftgs::detail

namespace swiftgs {

/// Renders frames: project, shade, bin, sort, rasterize. Every combination of policies is one type. The
/// default policies are as exact as float allows, and in most scenes the fastest or close to it.
template <class B, class Sort = EarlySort, class Raster = AxisSharedThreshold<FloatCholesky>,
          class Bounds = Ellipse>
requires(detail::check_policies<B, Sort, Raster, Bounds>()) class Renderer : public BoundRenderer<B> {
  static constexpr ComposedName name_storage{B::name, "/", Sort::name, "/", Raster::name, "/", Bounds::name};
  using OwnSort = SortStageOf<B, Sort, Bounds>;

 public:
  /// BACKEND/SORT/RASTER/BOUNDS
  static constexpr std::string_view name = name_storage.view();

  explicit Renderer(B backend = B(), Sort sort = Sort())
      : BoundRenderer<B>(std::string(name), std::move(backend), stage_table<B, Raster, Bounds>(),
                         std::make_unique<OwnSort>(std::move(sort))) {}

  Sort& sort() { return static_cast<OwnSort&>(this->stages().sort()).sort; }
  const Sort& sort() const { return const_cast<Renderer&>(*this).sort(); }
};

}  // namespace swiftgs
