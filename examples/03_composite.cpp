// SPDX-License-Identifier: Apache-2.0

// Composition: splats among the surfaces of another renderer. The host, here the small ray tracer of
// analytic_scene.hpp, has matrices, an RGBA8 image and a depth buffer as OpenGL programs do; the splats are
// then laid over the image, without those that lie at the host's depth or behind, so that surfaces hide
// splats and splats hide surfaces.
//
//     03_composite                      checks the frame
//     03_composite OUT.png              writes it too
//     03_composite OUT.png ray 4000     by depths along the ray, not of centres, of so many Gaussians
#include <cstddef>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/camera_matrices.hpp>
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
  std::vector<float> depth;  ///< 0 at the near plane, 1 where nothing is
};

HostFrame draw(const Camera& camera, const glm::mat4& projection) {
  HostFrame host;
  const analytic::View view = analytic::view_of(camera);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const analytic::Surface surface = analytic::draw_pixel(view, x, y);
      const glm::dvec4 clip = glm::dmat4(projection) * glm::dvec4(0, 0, -double(surface.depth), 1);
      host.image.push_back(surface.colour);
      host.depth.push_back(surface.depth == analytic::nowhere ? 1 : float(0.5 * clip.z / clip.w + 0.5));
    }
  return host;
}

}  // namespace

int main(int argc, char** argv) {
  // The host's matrices. In the world of the built-in scene y points down.
  const glm::mat4 view =
      glm::lookAt(glm::vec3(-0.9f, -1.5f, -4.0f), glm::vec3(0.03f, -0.9f, 0), glm::vec3(0, -1, 0));
  const glm::mat4 projection = glm::perspective(0.76f, float(width) / height, 0.1f, 500.0f);
  const HostCamera host_camera = camera_from(view, projection, width, height, ClipSpace::opengl);
  const Camera& camera = host_camera.camera;
  const HostFrame host = draw(camera, projection);

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
                        .stored_depth = host_camera.stored_depth,
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
    const float surface = host_camera.stored_depth.depth(host.depth[i]);
    wrong += alpha[i] == 0 ? image[i] != host.image[i] : depth[i] > 1.00001f * surface;
    hosts += alpha[i] == 0, mixed += alpha[i] > 0 && host.depth[i] < 1;
  }
  std::cout << hosts << " pixels show the host's surfaces alone, " << mixed << " have splats before them, "
            << wrong << " are wrong\n";
  return wrong == 0 && (hosts > 10'000 || argc > 3) && mixed > 10'000 ? 0 : 1;
}
