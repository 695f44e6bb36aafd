// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A box that a graphics library draws among the splats of the built-in scene: its cameras, what the host
/// composes of them, and what a loop of frames may take.

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include <doctest/doctest.h>
#include <glm/mat4x4.hpp>
#include <unistd.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/camera_matrices.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/default_view.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/swiftgs.hpp>

namespace swiftgs::test {

inline constexpr int width = 640, height = 400;
inline constexpr std::size_t pixels = std::size_t(width) * height;
using Bytes = std::vector<unsigned char>;

/// Frame k of a turn around the knot, in which the box is.
struct Seen {
  Seen(int k, ClipSpace clip) {
    const dvec3 target(0.02, -1.16, 0.02), up(0, -1, 0);
    const Camera start = look_at(target - dvec3(0, 0, 3), target, up, 0.76, width, height);
    const auto [view, projection] = matrices(orbit({start, target, up}, 0.31 * k, 0.2), 0.1, 500, clip);
    matrix = glm::mat4(projection * view);
    host = camera_from(view, projection, width, height, clip);
  }

  glm::mat4 matrix;  ///< of the box
  HostCamera host;
};

/// What the host draws, beside which frames of a device are judged.
class HostFrames {
 public:
  /// Splats over `image`, or before nothing where it is empty. Without `depth`, before all that it shows.
  Bytes draw(const HostCamera& host, PixelFormat format, Bytes image, const std::vector<float>& depth) {
    const bool over = !image.empty();
    image.resize(pixels * bytes_per_pixel(format));
    FrameView frame = host.frame(image.data(), depth.empty() ? nullptr : depth.data(), format);
    frame.over = over;
    renderer_.render_into(scene_.view(), host.camera, {}, frame);
    return image;
  }

  /// Checks that `drawn` has the splats before and behind the box that `box` and `depth` show.
  void check(const Bytes& drawn, const HostCamera& host, PixelFormat format, const Bytes& box,
             const std::vector<float>& depth) {
    const float clear = 1;
    std::vector<float> before_all = depth;
    for (float& value : before_all)
      if (value != clear) value = 0;
    CHECK(decibels(drawn, draw(host, format, box, depth)) >= 60);
    CHECK(decibels(drawn, draw(host, format, box, {})) < 40);
    CHECK(decibels(drawn, draw(host, format, box, before_all)) < 40);
  }

  static double decibels(const Bytes& a, const Bytes& b) {
    const auto values = [](const Bytes& bytes) {
      std::vector<float> out;
      for (const unsigned char byte : bytes) out.push_back(float(byte) / 255);
      return out;
    };
    return psnr(values(a), values(b));
  }

 private:
  Renderer<Cpu> renderer_;
  Cpu::SceneOn scene_ = renderer_.backend().upload(make_builtin_scene());
};

/// Frames of loops that look for growth: SWIFTGS_TEST_FRAMES, by default few.
inline int frames_of_loop() {
  const char* const asked = std::getenv("SWIFTGS_TEST_FRAMES");
  return asked ? std::atoi(asked) : 300;
}

/// Memory of this process that is resident. @units{bytes}
inline std::size_t resident_memory() {
  std::size_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * std::size_t(sysconf(_SC_PAGESIZE));
}

inline std::ptrdiff_t open_files() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

}  // namespace swiftgs::test
