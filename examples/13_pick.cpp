// SPDX-License-Identifier: Apache-2.0

// Picking: which Gaussian the middle pixel of a frame shows, and how many a rectangle around it shows. A tint
// highlights the Gaussian.
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <set>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

int main() {
  Renderer<Cpu> renderer;
  const Cpu::SceneOn scene = renderer.backend().upload(make_builtin_scene(20'000));
  const Camera camera = builtin_camera(640, 360);
  const Frame before = renderer.render(scene, camera);

  const PickedPixel middle = renderer.pick(320, 180);
  if (middle.gaussian == PickedPixel::nothing) return 1;
  std::cout << "Gaussian " << middle.gaussian << ", " << middle.depth << " m away, is "
            << int(100 * middle.weight) << "% of the middle pixel\n";

  std::set<std::uint32_t> shown;
  for (const PickedPixel& pixel : renderer.pick({.x = 304, .y = 164, .width = 32, .height = 32}))
    if (pixel.gaussian != PickedPixel::nothing) shown.insert(pixel.gaussian);
  std::cout << shown.size() << " Gaussians are the main ones of 32x32 pixels around it\n";

  const SceneView all = scene.view();
  const std::size_t picked = middle.gaussian, behind = picked + 1;
  const std::vector<PlacedScene> highlighted{{range_of(all, 0, picked)},
                                             {.scene = range_of(all, picked, 1), .tint = {vec3(1, 0, 1), 1}},
                                             {range_of(all, behind, all.size() - behind)}};
  const Frame after = renderer.render(highlighted, camera);
  std::size_t changed = 0;
  for (std::size_t i = 0; i < after.colour.size(); i += 3)
    changed += before.colour[i] != after.colour[i] || before.colour[i + 1] != after.colour[i + 1];
  std::cout << changed << " pixels show its highlight\n";
  return shown.count(middle.gaussian) == 1 && changed > 0 ? 0 : 1;
}
