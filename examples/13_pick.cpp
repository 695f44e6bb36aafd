// SPDX-License-Identifier: Apache-2.0

// Picking: which Gaussian the middle pixel of a frame shows, and how many a rectangle around it shows.
#include <cstdint>
#include <iostream>
#include <set>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

int main() {
  Renderer<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
  const Cpu::SceneOn scene = renderer.backend().upload(make_builtin_scene(20'000));
  const Camera camera = builtin_camera(640, 360);
  renderer.render(scene, camera);

  const PickedPixel middle = renderer.pick(320, 180);
  if (middle.gaussian == PickedPixel::nothing) return 1;
  std::cout << "Gaussian " << middle.gaussian << ", " << middle.depth << " m away, is "
            << int(100 * middle.weight) << "% of the middle pixel\n";

  std::set<std::uint32_t> shown;
  for (const PickedPixel& pixel : renderer.pick({.x = 304, .y = 164, .width = 32, .height = 32}))
    if (pixel.gaussian != PickedPixel::nothing) shown.insert(pixel.gaussian);
  std::cout << shown.size() << " Gaussians are the main ones of 32x32 pixels around it\n";
  return shown.count(middle.gaussian) == 1 ? 0 : 1;
}
