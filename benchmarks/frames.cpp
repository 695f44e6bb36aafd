// SPDX-License-Identifier: Apache-2.0

// Whole frames of every renderer that can run here: `frame` is the first view of a scene, `views` the mean
// over every eighth.
#include <swiftgs/any_renderer.hpp>

#include "stand.hpp"

namespace swiftgs::bench {

void add_benchmarks(Stand& stand, const Input& input) {
  for (const RendererEntry& entry : renderers()) {
    if (!entry.usable) continue;
    add_benchmark("frame", stand, entry, input, {input.views.front()}, &StageTimes::total);
    if (input.views.size() > 1) add_benchmark("views", stand, entry, input, input.views, &StageTimes::total);
  }
}

}  // namespace swiftgs::bench
