// SPDX-License-Identifier: Apache-2.0

// The stages of a frame, each as long as it takes in a whole frame, with the caches as the stage before
// leaves them. A stage is measured once for each of the policies that it depends on; the other words of its
// name are those of the policies that `swiftgs render` uses.
#include <string_view>

#include <swiftgs/any_renderer.hpp>

#include "stand.hpp"

namespace swiftgs::bench {
namespace {

/// Whether the word of `name` at position `part` is `word`.
bool has(std::string_view name, int part, std::string_view word) {
  for (int i = 0; i < part; ++i) name.remove_prefix(name.find('/') + 1);
  return name.substr(0, name.find('/')) == word;
}

}  // namespace

void add_benchmarks(Stand& stand, const Input& input) {
  for (const RendererEntry& entry : renderers()) {
    if (!entry.usable) continue;
    const bool usual_sort = has(entry.name, 1, "early"), usual_bounds = has(entry.name, 3, "ellipse");
    const bool usual_raster = has(entry.name, 2, "axis-shared-threshold-float-cholesky");
    const std::vector<Camera> view{input.views.front()};
    if (usual_sort && usual_raster && usual_bounds)
      add_benchmark("project", stand, entry, input, view, &StageTimes::project);
    if (usual_raster) add_benchmark("sort", stand, entry, input, view, &StageTimes::sort);
    if (usual_sort) add_benchmark("raster", stand, entry, input, view, &StageTimes::raster);
  }
}

}  // namespace swiftgs::bench
