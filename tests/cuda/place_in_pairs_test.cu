// SPDX-License-Identifier: Apache-2.0

// The kernels of projection as GPUs with few units for double compile them, on any GPU: frames of one view
// and of several, of a scene alone and of placed ones, against the serial backend, which projects in double.
#include <cmath>
#include <cstddef>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cuda.cuh>
#include <swiftgs/metrics.hpp>
#include <swiftgs/renderer.hpp>

#include "cuda/device.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

#if defined(__CUDA_ARCH__)
static_assert(projects_in_pairs);
#endif

/// Bounds that the library's own kernels do not know.
struct Boxes {
  static constexpr std::string_view name = "boxes";
  static constexpr bool conservative = true;
  struct Tiles {
    TileRect rect;
    SWIFTGS_HD TileRun row(int) const { return rect.columns; }
  };
  SWIFTGS_HD Tiles tiles(const SplatShape& shape, TileGrid grid) const {
    return {opacity_box(shape, EllipseExtent(shape), grid.side).within(grid)};
  }
};

template <class B>
using RendererOf = Renderer<B, EarlySort, PerPixel, Boxes>;

RenderSettings settings() {
  RenderSettings out;
  out.outputs.depth = true;
  return out;
}

/// Moves a scene and its camera together.
constexpr double distance = 2e4;
const dvec3 far_off = distance * dvec3(0.6, -0.5, 0.62);

Scene moved(Scene scene, dvec3 by) {
  for (vec3& mean : scene.means) mean = vec3(dvec3(mean) + by);
  return scene;
}
Camera moved(Camera camera, dvec3 by) {
  camera.translation -= camera.rotation * by;
  return camera;
}

/// Parts of the values that differ visibly: where rounding decides whether a pixel keeps a splat.
double part_apart(const std::vector<float>& found, const std::vector<float>& expected) {
  REQUIRE(found.size() == expected.size());
  REQUIRE(!found.empty());
  std::size_t apart = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
    apart += !(std::fabs(found[i] - expected[i]) <= 1e-4f * std::fmax(1.0f, std::fabs(expected[i])));
  return double(apart) / double(found.size());
}

void check_same(const Frame& found, const Frame& expected) {
  CHECK(psnr(found.colour, expected.colour) >= 80);
  CHECK(part_apart(found.colour, expected.colour) <= 0.002);
  CHECK(part_apart(found.depth, expected.depth) <= 0.002);
}

}  // namespace

SWIFTGS_DEVICE_CASE("cuda pairs: kernels that project in pairs draw a view as the serial backend does") {
  RendererOf<Cuda> renderer;
  RendererOf<Serial> serial;
  const Scene near = make_builtin_scene(20'000);
  for (const dvec3 by : {dvec3(0), far_off}) {
    CAPTURE(by.x);
    const Scene scene = moved(near, by);
    const DeviceScene uploaded = renderer.backend().upload(scene);
    const SceneView on_host = view(scene);
    for (const Camera& camera : builtin_cameras(2, 320, 180)) {
      const Camera there = moved(camera, by);
      check_same(renderer.render(uploaded, there, settings()), serial.render(on_host, there, settings()));
    }
  }
}

SWIFTGS_DEVICE_CASE("cuda pairs: kernels that project in pairs draw several views and placed scenes") {
  RendererOf<Cuda> renderer;
  RendererOf<Serial> serial;
  const Scene scene = make_builtin_scene(20'000);
  const DeviceScene uploaded = renderer.backend().upload(scene);
  Similarity pose;
  // A quarter turn about y, twice as large, far from the origin.
  pose.rotation = dmat3(dvec3(0, 0, -1), dvec3(0, 1, 0), dvec3(1, 0, 0));
  pose.scale = 2, pose.translation = far_off;
  const auto placed = [&](const SceneView& view) {
    return std::vector<PlacedScene>{{view, pose}, {view, {dmat3(1.0), 1, far_off}}};
  };
  const std::vector<Camera> cameras = builtin_cameras(3, 320, 180);
  std::vector<Camera> there;
  for (const Camera& camera : cameras) there.push_back(moved(camera, far_off));
  const auto check = [&](const PlacedScenes& on_device, const PlacedScenes& on_host,
                         const std::vector<Camera>& all) {
    std::vector<Frame> found(all.size());
    renderer.render(on_device, {all.data(), all.size()}, settings(), {found.data(), found.size()});
    for (std::size_t k = 0; k < all.size(); ++k)
      check_same(found[k], serial.render(on_host, all[k], settings()));
  };
  check(uploaded, view(scene), cameras);
  check(placed(uploaded.view()), placed(view(scene)), there);
  check(placed(uploaded.view()), placed(view(scene)), {there[1]});
}
