// SPDX-License-Identifier: Apache-2.0

// The library's shortest contract: every backend and every exact rasterizer draws every clause of the
// conformance set as exactly as floats allow. A new backend starts here.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/stress.hpp>

#include "measure/conformance_set.hpp"
#include "policies/backends.hpp"

namespace swiftgs::test {
namespace {

/// Renderers of a backend that follow a preset but for rounding.
std::vector<std::unique_ptr<AnyRenderer>> exact_renderers(std::string_view backend, std::string_view bounds) {
  std::vector<std::unique_ptr<AnyRenderer>> found;
  for (const RendererEntry& entry : renderers())
    if (const std::string_view name = entry.name; name.starts_with(std::string(backend) + "/early/") &&
                                                  name.ends_with(bounds) &&
                                                  name.find("half-split") == name.npos)
      found.push_back(entry.make());
  return found;
}

/// Draws all clauses of `preset` and judges them as hard frames are judged.
void check_preset(std::string_view backend, const std::string& preset, std::string_view bounds) {
  const auto renderers = exact_renderers(backend, bounds);
  CHECK(renderers.size() == 5);
  const cli::ConformanceSet set = cli::read_conformance_set(SWIFTGS_CONFORMANCE_SET);
  CHECK(set.clauses.size() == 46);
  for (const cli::Clause& clause : set.clauses) {
    CAPTURE(clause.name);
    const auto scene = std::make_shared<const Scene>(clause.read_scene());
    const Camera camera = clause.read_camera();
    RenderSettings settings;
    settings.conventions = clause.conventions(preset), settings.background = clause.background;
    settings.outputs.alpha = true;
    // What renderers leave out is their bounds' affair, and none of these has Khronos' ellipse.
    Conventions drawn = settings.conventions;
    if (preset == "khronos") drawn.footprint = Conventions::Footprint::alpha;
    const ConditionedFrame reference = render_conditioned(*scene, camera, drawn, dvec3(clause.background));
    for (const auto& renderer : renderers) {
      CAPTURE(renderer->name());
      renderer->set_scene(scene);
      Frame frame;
      renderer->render(camera, settings, frame);
      CHECK(judge(reference, frame, exponent_representation_named(renderer->name())).normalised_error <= 10);
    }
  }
}

SWIFTGS_CONTRACT("conformance: every exact rasterizer draws every clause by gsplat") {
  check_preset(B::name, "gsplat", "/ellipse");
}

SWIFTGS_CONTRACT("conformance: every exact rasterizer draws every clause by inria") {
  check_preset(B::name, "inria", "/three-sigma-square");
}

SWIFTGS_CONTRACT("conformance: every exact rasterizer draws every clause by khronos but for the cut") {
  check_preset(B::name, "khronos", "/ellipse");
}

}  // namespace
}  // namespace swiftgs::test
