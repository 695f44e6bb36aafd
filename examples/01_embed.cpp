// SPDX-License-Identifier: Apache-2.0

// Embedding: a renderer inside a program that has its own pixels. Four views of one scene are rendered
// straight into the quarters of one image, as a program with several viewports would do; nothing is copied.
#include <cstddef>
#include <iostream>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

int main() {
  // The program's own image. Rows may be longer than what is shown, as those of textures often are.
  constexpr int width = 320, height = 180;
  constexpr std::size_t pitch = 3 * (2 * width + 24);  // in floats
  std::vector<float> image(pitch * 2 * height, -1.0f);

  // The renderer keeps the memory of its stages from frame to frame; the backend runs on as many threads as
  // it is told, here on all.
  Renderer<Cpu> renderer;

  // A scene is uploaded once. This one needs no file; `load_scene` of <swiftgs/io/scene_file.hpp> reads one.
  const Cpu::SceneOn scene = renderer.backend().upload(make_builtin_scene(20'000));

  RenderSettings settings;
  settings.conventions = Conventions::gsplat();
  settings.background = vec3(0.10f, 0.12f, 0.15f);
  settings.time = true;

  // Render each view into its quarter: a pointer to its first pixel, and the distance from row to row, in
  // bytes.
  const std::vector<Camera> cameras = builtin_cameras(4, width, height);
  for (std::size_t view = 0; view < cameras.size(); ++view) {
    float* const quarter = image.data() + (view / 2 * height) * pitch + (view % 2) * 3 * width;
    // Alpha and depth are null, hence not wanted, hence not computed.
    const FrameView frame{.width = width, .height = height, .colour = {quarter, pitch * sizeof(float)}};
    try {
      renderer.render_into(scene.view(), cameras[view], settings, frame);
    } catch (const CapacityError& error) {
      // A frame that needs more than there can be ends here; the renderer can go on with the next.
      std::cerr << cameras[view].name << ": " << error.what() << '\n';
      return 1;
    }
    std::cout << cameras[view].name << ": " << renderer.statistics().visible << " Gaussians in view, "
              << renderer.times().total << " ms\n";
  }

  // Every pixel of the four quarters has been written, and nothing beside them.
  std::size_t untouched = 0;
  for (const float value : image) untouched += value < 0;
  const std::size_t beside = (pitch - 3 * 2 * width) * 2 * height;
  std::cout << renderer.name << ": " << image.size() - untouched << " values written\n";
  return untouched == beside ? 0 : 1;
}
