// SPDX-License-Identifier: Apache-2.0

// A plugin that brings the libraries to a program that does not know them.
#include <memory>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/swiftgs.hpp>

namespace {

const auto scene = std::make_shared<const swiftgs::Scene>(swiftgs::make_builtin_scene(500));
const swiftgs::Camera camera = swiftgs::scaled(swiftgs::builtin_camera(), 0.05);

bool renders_by_type() {
  using namespace swiftgs;
  Renderer<Cpu> renderer;
  write_png("plugin.png", renderer.render(renderer.backend().upload(scene), camera));
  return read_image("plugin.png").width == camera.width;
}

/// Renderers that share a scene find each other's type by `dynamic_cast`.
bool renders_by_name() {
  const auto first = swiftgs::make_renderer("cpu/early/per-pixel/ellipse");
  const auto second = swiftgs::make_renderer("cpu/standard/axis-shared-float-split/opacity-box");
  first->set_scene(scene);
  return second->share_scene(*first);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) bool plugin_renders() {
  return renders_by_type() && renders_by_name();
}

/// Throws what a library throws, for the program to catch.
extern "C" __attribute__((visibility("default"))) void plugin_throws(int what) {
  const std::byte junk[64]{};
  if (what == 0) swiftgs::read_scene(junk, "junk");
  if (what == 1) throw swiftgs::CapacityError("plugin", 2, 1);
  swiftgs::make_renderer("no renderer");
}
