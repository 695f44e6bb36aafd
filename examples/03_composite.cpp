// SPDX-License-Identifier: Apache-2.0

// Composition: splats among the surfaces of another renderer. The host, here the small ray tracer of
// analytic_scene.hpp, draws into its own RGBA8 image and depth buffer; the splats are then laid over the
// image, without those that lie at the host's depth or behind, so that surfaces hide splats and splats hide
// surfaces.
//
//     03_composite                      checks the frame
//     03_composite OUT.png              writes it too
//     03_composite OUT.png ray 4000     by depths along the ray, not of centres, of so many Gaussians
#include <cstddef>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/swiftgs.hpp>

#include "analytic_scene.hpp"

using namespace swiftgs;

namespace {

constexpr int width = 1280, height = 720;

/// What the host has drawn before splats come.
struct HostFrame {
  std::vector<analytic::Rgba8> image;
  std::vector<float> depth;
};

HostFrame draw(const Camera& camera) {
  HostFrame host;
  const analytic::View view = analytic::view_of(camera);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const analytic::Surface surface = analytic::draw_pixel(view, x, y);
      host.image.push_back(surface.colour), host.depth.push_back(surface.depth);
    }
  return host;
}

}  // namespace

int main(int argc, char** argv) {
  const Camera camera = builtin_camera(width, height);
  const HostFrame host = draw(camera);

  // Lay the splats over a copy of the host's image, so that the two can be compared below.
  Renderer<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
  const Cpu::SceneOn scene =
      renderer.backend().upload(argc > 3 ? make_builtin_scene(std::stoul(argv[3])) : make_builtin_scene());
  RenderSettings settings;
  // Of a large splat that a surface cuts, parts lie on both sides: the surface hides what is behind it.
  if (argc > 2 && std::string_view(argv[2]) == "ray")
    settings.conventions.depth_at = Conventions::DepthAt::ray;
  std::vector<analytic::Rgba8> image = host.image;
  std::vector<float> alpha(host.depth.size()), depth(host.depth.size());
  renderer.render_into(scene.view(), camera, settings,
                       {.width = width,
                        .height = height,
                        .colour = {image.data(), sizeof(analytic::Rgba8) * width},
                        .format = PixelFormat::rgba_8,
                        .alpha = {alpha.data(), sizeof(float) * width},
                        .depth = {depth.data(), sizeof(float) * width},
                        .occluder = {host.depth.data(), sizeof(float) * width},
                        .over = true});

  if (argc > 1) {
    Frame frame{.width = width, .height = height, .colour = {}, .alpha = {}, .depth = {}};
    for (const analytic::Rgba8 p : image)
      for (const int channel : {p.r, p.g, p.b}) frame.colour.push_back(float(channel) / 255);
    write_png(argv[1], frame);
  }

  // Where no splat is drawn the host's pixel is untouched, and where one is it lies before the host's
  // surface. Depths are rounded.
  std::size_t wrong = 0, hosts = 0, mixed = 0;
  for (std::size_t i = 0; i < image.size(); ++i) {
    wrong += alpha[i] == 0 ? image[i] != host.image[i] : depth[i] > 1.00001f * host.depth[i];
    hosts += alpha[i] == 0, mixed += alpha[i] > 0 && host.depth[i] != analytic::nowhere;
  }
  std::cout << hosts << " pixels show the host's surfaces alone, " << mixed << " have splats before them, "
            << wrong << " are wrong\n";
  return wrong == 0 && (hosts > 10'000 || argc > 3) && mixed > 10'000 ? 0 : 1;
}
