// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include <swiftgs/bound_renderer.hpp>
#include <swiftgs/bounds/ellipse.hpp>
#include <swiftgs/composed_name.hpp>
#include <swiftgs/policy_checks.hpp>
#include <swiftgs/raster/axis_shared.hpp>
#include <swiftgs/sort/early.hpp>
#include <swiftgs/stages.hpp>

namespace swiftgs {

/// Renders frames: project, shade, bin, sort, rasterize. Every combination of policies is one type. Those of
/// `Renderer<Cpu>` are as exact as float allows, and in most scenes the fastest or close to it.
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
