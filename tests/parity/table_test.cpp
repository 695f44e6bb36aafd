// SPDX-License-Identifier: Apache-2.0
#include <iterator>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/random_splats.hpp"

using namespace swiftgs;

namespace {

const std::string_view backends[] = {"serial",
#if defined(SWIFTGS_HAS_VULKAN)
                                     "vulkan",
#endif
#if defined(SWIFTGS_HAS_CUDA)
                                     "cuda",
#endif
                                     "cpu"};
const std::string_view sorts[] = {"standard", "early", "adaptive"};
const std::string_view rasters[] = {"per-pixel",
                                    "axis-shared-half-split",
                                    "axis-shared-float-split",
                                    "axis-shared-float-cholesky",
                                    "axis-shared-threshold-half-split",
                                    "axis-shared-threshold-float-split",
                                    "axis-shared-threshold-float-cholesky"};
const std::string_view bounds[] = {"three-sigma-square", "opacity-box", "ellipse"};

}  // namespace

TEST_CASE("table: every combination of policies is there once under its composed name") {
  std::set<std::string> names;
  for (const RendererEntry& entry : renderers()) {
    names.insert(std::string(entry.name));
    // Whether a device is there depends on the machine.
    if (!entry.on_device) CHECK(entry.usable);
    CHECK(entry.on_device == (entry.name.starts_with("cuda/") || entry.name.starts_with("vulkan/")));
  }
  CHECK(renderers().size() == std::size(backends) * AllSorts::size * AllRasters::size * AllBounds::size);
  CHECK(names.size() == renderers().size());
  // Names that programs and recorded results rely on.
  for (const auto backend : backends)
    for (const auto sort : sorts)
      for (const auto raster : rasters)
        for (const auto bound : bounds) {
          std::string name(backend);
          name.append("/").append(sort).append("/").append(raster).append("/").append(bound);
          CAPTURE(name);
          CHECK(names.count(name) == 1);
        }
}

TEST_CASE("table: a name that is not there is refused with all words that could stand in it") {
  for (const char* name :
       {"", "cpu", "cpu/early/per-pixel", "cpu/early/per-pixel/ellipse/", "gpu/early/per-pixel/ellipse",
        "cpu/early/per-pixel/Ellipse", "cpu/per-pixel/early/ellipse"}) {
    CAPTURE(name);
    std::string message;
    try {
      make_renderer(name);
    } catch (const std::invalid_argument& error) {
      message = error.what();
    }
    std::string refusal("'");
    refusal.append(name).append("' is not known");
    CHECK(message.find(refusal) != std::string::npos);
    CHECK(message.find("BACKEND/SORT/RASTER/BOUNDS") != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
    const auto has_all = [&](const auto& words) {
      for (const std::string_view word : words) CHECK(message.find(word) != std::string::npos);
    };
    has_all(backends), has_all(sorts), has_all(rasters), has_all(bounds);
  }
}

TEST_CASE("table: a renderer asks for a scene before it renders") {
  const auto renderer = make_renderer("serial/early/per-pixel/ellipse");
  Frame frame;
  CHECK_THROWS_AS(renderer->render(test::forward_camera(8, 8), {}, frame), std::logic_error);
  CHECK_THROWS_AS(renderer->set_scene(nullptr), std::invalid_argument);
}
