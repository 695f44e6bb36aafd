// SPDX-License-Identifier: Apache-2.0

// Frames over ranks, one after the other, for tests that stop them: frames_in_a_loop FRAMES [RANK]. Rank 0
// writes each image, and behind it a scene, which takes a while, in place of the last one. RANK throws as
// soon as there is a file `throw`, and writes to `thrown.txt` when that was.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/mpi.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

int main(int argc, char** argv) {
  const int frames = argc > 1 ? std::atoi(argv[1]) : 1, thrower = argc > 2 ? std::atoi(argv[2]) : -1;
  return run_on_ranks("frames_in_a_loop", [&](Ranks& ranks) {
    DistributedRenderer<Cpu, EarlySort, PerPixel, Ellipse> renderer(ranks, Cpu(1));
    const auto part = renderer.backend().upload(
        make_builtin_scene(5'000, {std::size_t(ranks.rank()), std::size_t(ranks.size())}));
    const Scene long_to_write = ranks.rank() == 0 ? make_builtin_scene(20'000) : Scene();
    const auto name_of = [](int k) { return "scene-" + std::to_string(k) + ".ply"; };
    Frame frame;
    for (int k = 0; k < frames; ++k) {
      if (ranks.rank() == thrower && std::filesystem::exists("throw")) {
        std::ofstream("thrown.txt") << std::chrono::steady_clock::now().time_since_epoch().count();
        throw std::runtime_error("thrown by a test");
      }
      renderer.render(part.view(), builtin_camera(300, 200), {}, frame);
      if (ranks.rank() != 0) continue;
      write_png("frame-" + std::to_string(k) + ".png", frame);
      write_scene(name_of(k), long_to_write);
      std::filesystem::remove(name_of(k - 1));
    }
    return 0;
  });
}
