// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

int main() {
  Renderer<Cpu> renderer;
  const Cpu::SceneOn scene = renderer.backend().upload(make_builtin_scene());
  write_png("frame.png", renderer.render(scene, builtin_camera()));
}
