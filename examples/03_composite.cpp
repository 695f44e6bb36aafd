// SPDX-License-Identifier: Apache-2.0

// Composition: splats among the surfaces of another renderer. The host, here a small ray tracer, draws into
// its own RGBA8 image and depth buffer; the splats are then laid over the image, each pixel ending at the
// host's depth, so that surfaces hide splats and splats hide surfaces. The frame is written as PNG to the
// path that is given.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

namespace {

constexpr int width = 1280, height = 720;
constexpr float nowhere = std::numeric_limits<float>::infinity();

struct Sphere {
  dvec3 centre;  ///< y points down, as in the scene
  double radius;
  dvec3 colour;
};
const Sphere spheres[] = {{{0.02, -1.16, 0.02}, 0.30, {1.0, 0.55, 0.10}},      // in the knot
                          {{-0.03, -0.28, -1.20}, 0.22, {0.75, 0.08, 0.25}}};  // on the floor
constexpr double floor_y = -0.06, floor_radius = 1.75;
const dvec3 sun = glm::normalize(dvec3(-0.74, -0.52, -0.34));

/// Where a ray ends; at infinity where it meets nothing.
struct Hit {
  double t = nowhere;
  dvec3 normal{0}, colour{0};
};

Hit trace(dvec3 from, dvec3 along) {
  Hit hit;
  for (const Sphere& sphere : spheres) {
    const dvec3 offset = from - sphere.centre;
    const double a = glm::dot(along, along), b = glm::dot(offset, along);
    const double root = b * b - a * (glm::dot(offset, offset) - sphere.radius * sphere.radius);
    const double t = root > 0 ? (-b - std::sqrt(root)) / a : -1;
    if (t > 1e-6 && t < hit.t) hit = {t, (offset + t * along) / sphere.radius, sphere.colour};
  }
  const double t = (floor_y - from.y) / along.y;
  const dvec3 at = from + t * along;
  if (t > 1e-6 && t < hit.t && at.x * at.x + at.z * at.z < floor_radius * floor_radius) {
    const bool dark = (int(std::floor(3 * at.x)) + int(std::floor(3 * at.z))) % 2 == 0;
    hit = {t, dvec3(0, -1, 0), dark ? dvec3(0.10, 0.11, 0.13) : dvec3(0.75, 0.73, 0.68)};
  }
  return hit;
}

/// Light that comes back: sun with shadow and highlight, and sky from above.
dvec3 shade(const Hit& hit, dvec3 at, dvec3 along) {
  const bool lit = trace(at + 1e-4 * hit.normal, sun).t == nowhere;
  const double sunlight = lit ? std::max(0.0, glm::dot(hit.normal, sun)) : 0.0;
  const dvec3 half_way = glm::normalize(sun - glm::normalize(along));
  const double highlight = lit ? std::pow(std::max(0.0, glm::dot(hit.normal, half_way)), 80.0) : 0.0;
  const dvec3 sky = dvec3(0.20, 0.26, 0.36) * (0.6 - 0.4 * hit.normal.y);
  return hit.colour * (sky + dvec3(1.0, 0.88, 0.70) * sunlight) + 0.6 * highlight;
}

/// What the host has drawn before splats come.
struct HostFrame {
  std::vector<std::uint8_t> image = std::vector<std::uint8_t>(4 * std::size_t(width) * height);
  std::vector<float> depth = std::vector<float>(std::size_t(width) * height, nowhere);
};

HostFrame draw(const Camera& camera) {
  HostFrame host;
  const dvec3 eye = camera.centre();
  for (std::size_t i = 0; i < host.depth.size(); ++i) {
    // A ray whose camera-space z is 1: where it ends is the depth that splats are compared with.
    const double x = (double(i % width) + 0.5 - camera.cx) / camera.fx;
    const double y = (double(i / width) + 0.5 - camera.cy) / camera.fy;
    const dvec3 along = dvec3(x, y, 1) * camera.rotation;
    const Hit hit = trace(eye, along);
    if (hit.t == nowhere) continue;
    const dvec3 light = shade(hit, eye + hit.t * along, along);
    for (int c = 0; c < 3; ++c) host.image[4 * i + std::size_t(c)] = to_unorm8(float(std::sqrt(light[c])));
    host.image[4 * i + 3] = 255;
    host.depth[i] = float(hit.t);
  }
  return host;
}

}  // namespace

int main(int argc, char** argv) {
  const Camera camera = builtin_camera(width, height);
  const HostFrame host = draw(camera);

  // Lay the splats over a copy of the host's image, so that the two can be compared below.
  Renderer<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
  const Cpu::SceneOn scene = renderer.backend().upload(make_builtin_scene());
  std::vector<std::uint8_t> image = host.image;
  std::vector<float> alpha(host.depth.size()), depth(host.depth.size());
  renderer.render_into(scene.view(), camera, {},
                       {.width = width,
                        .height = height,
                        .colour = {image.data(), 4 * width},
                        .format = PixelFormat::rgba_8,
                        .alpha = {alpha.data(), sizeof(float) * width},
                        .depth = {depth.data(), sizeof(float) * width},
                        .occluder = {host.depth.data(), sizeof(float) * width},
                        .over = true});

  if (argc > 1) {
    Frame frame{.width = width, .height = height, .colour = {}, .alpha = {}, .depth = {}};
    for (std::size_t i = 0; i < image.size(); ++i)
      if (i % 4 != 3) frame.colour.push_back(float(image[i]) / 255);
    write_png(argv[1], frame);
  }

  // Where no splat is drawn the host's pixel is untouched, and where one is it lies before the host's
  // surface.
  std::size_t wrong = 0, hosts = 0, mixed = 0;
  for (std::size_t i = 0; i < host.depth.size(); ++i) {
    const bool untouched = std::equal(&image[4 * i], &image[4 * i] + 4, &host.image[4 * i]);
    wrong += alpha[i] == 0 ? !untouched : depth[i] >= host.depth[i];
    hosts += alpha[i] == 0, mixed += alpha[i] > 0 && host.depth[i] != nowhere;
  }
  std::cout << hosts << " pixels show the host's surfaces alone, " << mixed << " have splats before them, "
            << wrong << " are wrong\n";
  return wrong == 0 && hosts > 10'000 && mixed > 10'000 ? 0 : 1;
}
