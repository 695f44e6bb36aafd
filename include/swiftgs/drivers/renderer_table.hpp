// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Rows of the table of renderers.

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/drivers/bound_renderer.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/functor/stage_table.hpp>
#include <swiftgs/tools/policy_lists.hpp>

namespace swiftgs {

namespace detail {
template <class B, class Sort, class Bounds>
std::unique_ptr<SortStage<B>> make_sort() {
  return std::make_unique<SortStageOf<B, Sort, Bounds>>();
}
}  // namespace detail

/// Appends every combination of backend `B` with the given sorts, rasterizers and bounds to `table`.
/// backends/table.cpp holds the library's lists. A policy on a device also needs code that its compiler
/// makes.
template <class B, class... Sorts, class... Rasters, class... Bounds>
void append_renderers(std::vector<RendererEntry>& table, TypeList<Sorts...>, TypeList<Rasters...>,
                      TypeList<Bounds...>) {
  using MakeSort = std::unique_ptr<SortStage<B>> (*)();
  const std::vector<BoundsStages<B>> all_bounds{bounds_stages<B, Bounds>()...};
  const std::vector<RasterStage<B>> all_rasters{raster_stage<B, Rasters>()...};
  const auto append = [&](std::string_view sort, const std::vector<MakeSort>& within) {
    for (const RasterStage<B>& raster : all_rasters)
      for (std::size_t k = 0; k < all_bounds.size(); ++k) {
        const BoundsStages<B>& bounds = all_bounds[k];
        std::string name{B::name};
        for (const std::string_view word : {sort, raster.name, bounds.name}) name.append("/").append(word);
        const auto make = [=, make_sort = within[k]](const BackendOptions& options) {
          return std::unique_ptr<AnyRenderer>(std::make_unique<BoundRenderer<B>>(
              name, make_backend(std::type_identity<B>(), options),
              StageTable<B>{bounds, raster, common_stages<B>()}, make_sort()));
        };
        table.push_back({name, B::usable(), !B::reaches_host_memory, make});
      }
  };
  const auto append_sort = [&]<class Sort>() {
    append(Sort::name, {&detail::make_sort<B, Sort, Bounds>...});
  };
  (append_sort.template operator()<Sorts>(), ...);
}

}  // namespace swiftgs
