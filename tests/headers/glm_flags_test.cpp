// SPDX-License-Identifier: Apache-2.0

// A program whose GLM has other defaults than the library: its own vectors are aligned. CMakeLists.txt beside
// this defines the flags; the library that is linked is compiled without.
#include <cmath>
#include <memory>

#include <doctest/doctest.h>
#include <glm/vec3.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

static_assert(sizeof(glm::vec3) == 16 && sizeof(vec3) == 12,
              "the flags are there, and the library's are its own");

TEST_CASE("headers: a program with aligned GLM draws what the library's kernels draw") {
  const Scene scene = make_builtin_scene(3000);
  Camera camera = builtin_camera(96, 64);
  camera = transformed(camera, {.translation = glm::dvec3(0.01, 0.02, 0.03)});  // of the program's own type
  RenderSettings settings;
  settings.background = glm::vec3(0.2f, 0.4f, 0.8f);
  Renderer<Cpu> compiled;
  Renderer<Serial> here;
  const Frame theirs = compiled.render(compiled.backend().upload(scene), camera, settings);
  const Frame ours = here.render(here.backend().upload(scene), camera, settings);
  CHECK(psnr(theirs.colour, ours.colour) > 100);
  CHECK(theirs.colour[0] != theirs.colour[2]);
}
