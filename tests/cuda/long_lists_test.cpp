// SPDX-License-Identifier: Apache-2.0

// Lists that no warp walks alone: many warps blend their pieces, with the bits of one warp that blends them
// all.
#include <cstddef>
#include <utility>
#include <vector>

#include <swiftgs/cpu.hpp>

#include "cuda/device.hpp"
#include "policies/random_splats.hpp"
#include "policies/rasterizers.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// Faint Gaussians, one behind the other, that reach over much of an image: pixels stop at very different
/// places of very long lists.
Scene layers(std::size_t count, double faintest, double densest) {
  Random random(count);
  Scene scene = random_scene(count, 0, count);
  for (std::size_t i = 0; i < count; ++i) {
    const float z = 2 + 8 * float(i) / float(count), side = 0.5f * z;
    const float x = random.f(-side, side), y = random.f(-side, side);
    scene.means[i] = vec3(x, y, z);
    const float wide = random.f(0.1 * z, 0.8 * z), narrow = random.f(0.1 * z, 0.8 * z);
    scene.scales[i] = vec3(wide, narrow, 0.01f);
    scene.opacities[i] = float(random.scale(faintest, densest));
  }
  return scene;
}

Camera square_camera(int side) {
  Camera camera = forward_camera(side, side, side);
  camera.cx = camera.cy = 0.5 * side;
  return camera;
}

/// Colour, alpha and depth of an image in device memory, rows of the image `side` wide.
struct Planes {
  DeviceBuffer<float> colour, alpha, depth;
  int side;

  explicit Planes(int of) : side(of) {
    const std::size_t pixels = std::size_t(of) * std::size_t(of);
    colour.reset(3 * pixels), alpha.reset(pixels), depth.reset(pixels);
  }
  /// A part of the image, from a pixel on.
  FrameView part(int size, FirstPixel first, bool extras) {
    const std::size_t at = std::size_t(first.y) * std::size_t(side) + std::size_t(first.x);
    const auto row = std::ptrdiff_t(sizeof(float)) * side;
    FrameView frame{.width = size, .height = size, .colour = {colour.data() + 3 * at, 3 * row}};
    frame.alpha = {alpha.data() + at, row};
    if (extras) frame.depth = {depth.data() + at, row};
    return frame;
  }
};

/// Renders an image as a whole and in parts before white, and compares their bits.
template <class R>
void check_parts(R& renderer, const SceneView& scene, int side, int size, bool extras,
                 const Conventions& conventions = {}) {
  CAPTURE(R::name);
  CAPTURE(side);
  CAPTURE(extras);
  const Camera camera = square_camera(side);
  Planes whole(side), parts(side);
  const View view = make_view(camera, conventions, whole.part(side, {}, extras), vec3(1));
  renderer.render_into(scene, {&view, 1});
  for (int y = 0; y < side; y += size)
    for (int x = 0; x < side; x += size) {
      const View part = make_view(camera, conventions, parts.part(size, {x, y}, extras), vec3(1), {x, y});
      renderer.render_into(scene, {&part, 1});
    }
  const Cuda& cuda = renderer.backend();
  const auto same = [&](const DeviceBuffer<float>& a, const DeviceBuffer<float>& b) {
    return to_host(cuda, a.span()) == to_host(cuda, b.span());
  };
  CHECK(same(std::as_const(whole.colour), std::as_const(parts.colour)));
  CHECK(same(std::as_const(whole.alpha), std::as_const(parts.alpha)));
  if (extras) CHECK(same(std::as_const(whole.depth), std::as_const(parts.depth)));
}

template <class Raster>
using With = Renderer<Cuda, EarlySort, Raster, Ellipse>;

/// Calls f(renderer) for each rasterizer that cuts lists into pieces.
template <class F>
void for_each_piecewise(const F& f) {
  f(With<AxisSharedThreshold<FloatCholesky>>());
  f(With<AxisShared<FloatCholesky>>());
  f(With<AxisSharedThreshold<FloatSplit>>());
  f(With<AxisShared<FloatSplit>>());
}

SquareCounts counts_of(auto& renderer, const DeviceScene& scene, const Camera& camera) {
  RenderSettings settings;
  settings.count = true;
  Frame frame;
  renderer.render(scene, camera, settings, frame);
  return renderer.statistics().raster;
}

}  // namespace

TEST_CASE("cuda long lists: parts that blocks share have the bits of parts that a warp walks") {
  if (without_device()) return;
  // The whole image has more long parts than there is room for, so warps walk the rest of them alone.
  const Scene scene = layers(3500, 0.004, 0.05);
  for_each_piecewise([&](auto&& renderer) {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    for (const bool extras : {false, true}) check_parts(renderer, uploaded.view(), 1024, 256, extras);
  });
}

TEST_CASE("cuda long lists: parts that clusters share have the bits of parts that blocks share") {
  if (without_device()) return;
  const Scene scene = layers(40'000, 0.004, 0.0055);
  for_each_piecewise([&](auto&& renderer) {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    for (const bool extras : {false, true}) check_parts(renderer, uploaded.view(), 384, 128, extras);
  });
}

TEST_CASE("cuda long lists: lists that end with a piece have the same bits too") {
  if (without_device()) return;
  // Black before white, so that a pixel is its transmittance. None stops, and each part keeps every splat.
  Scene scene = layers(1024 + 16 * 128, 0.004, 0.0045);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    scene.means[i].x = scene.means[i].y = 0;
    scene.scales[i] = vec3(50, 50, 0.01f);
    scene.sh0[i] = vec3(-10);
  }
  Conventions conventions;
  conventions.stop = 0;
  for_each_piecewise([&](auto&& renderer) {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    for (const bool extras : {false, true})
      check_parts(renderer, uploaded.view(), 1024, 256, extras, conventions);
  });
}

TEST_CASE("cuda long lists: every sort and every lossless bounds give the same bits, run after run") {
  if (without_device()) return;
  const Scene scene = layers(30'000, 0.004, 0.02);
  const Camera camera = square_camera(96);
  std::vector<float> expected;
  for_each_type(AllSorts(), [&]<class Sort>(Sort) {
    for_each_type(AllBounds(), [&]<class Bounds>(Bounds) {
      if constexpr (Bounds::lossless) {
        CAPTURE(Sort::name);
        CAPTURE(Bounds::name);
        Renderer<Cuda, Sort, AxisSharedThreshold<FloatCholesky>, Bounds> renderer;
        const DeviceScene uploaded = renderer.backend().upload(scene);
        for (int run = 0; run < 5; ++run) {
          const std::vector<float> drawn = renderer.render(uploaded, camera).colour;
          if (expected.empty()) expected = drawn;
          CHECK((drawn == expected));
        }
      }
    });
  });
}

TEST_CASE("cuda long lists: frames are those of hosts, and their counts") {
  if (without_device()) return;
  const Camera camera = square_camera(64);
  for (const auto& [count, densest] : {std::pair(3000, 0.05), {30'000, 0.006}, {30'000, 0.3}}) {
    CAPTURE(count);
    CAPTURE(densest);
    const Scene scene = layers(std::size_t(count), 0.004, densest);
    Renderer<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> host;
    RenderSettings settings;
    settings.count = true, settings.outputs = {true, true};
    Frame expected, drawn;
    host.render(host.backend().upload(scene), camera, settings, expected);
    const SquareCounts counted = host.statistics().raster;
    for_each_piecewise([&](auto&& renderer) {
      CAPTURE(std::decay_t<decltype(renderer)>::name);
      const DeviceScene uploaded = renderer.backend().upload(scene);
      renderer.render(uploaded, camera, settings, drawn);
      double colour = 0, alpha = 0, depth = 0;
      for (std::size_t i = 0; i < drawn.colour.size(); ++i)
        colour = std::max(colour, std::abs(double(drawn.colour[i]) - double(expected.colour[i])));
      for (std::size_t i = 0; i < drawn.alpha.size(); ++i) {
        alpha = std::max(alpha, std::abs(double(drawn.alpha[i]) - double(expected.alpha[i])));
        depth = std::max(depth, std::abs(double(drawn.depth[i]) - double(expected.depth[i])));
      }
      // A splat at alpha 1/255 that only one of both keeps, of a thousand that each pixel shows.
      CHECK(colour < 0.005);
      CHECK(alpha < 0.001);
      CHECK(depth < 0.05);
      const SquareCounts counts = renderer.statistics().raster;
      CHECK(double(counts.contributing_pairs) ==
            doctest::Approx(double(counted.contributing_pairs)).epsilon(2e-3));
      CHECK(double(counts.pixels_stopped) == doctest::Approx(double(counted.pixels_stopped)).epsilon(1e-2));
    });
  }
}

TEST_CASE("cuda long lists: counts tell of pieces where lists are long alone") {
  if (without_device()) return;
  With<AxisSharedThreshold<FloatCholesky>> renderer;
  const Camera camera = square_camera(64);
  const SquareCounts usual = counts_of(renderer, renderer.backend().upload(layers(500, 0.004, 0.01)), camera);
  CHECK(usual.pieces == 0);
  CHECK(usual.pixels_joined == 0);
  CHECK(usual.longest_item > 100);
  CHECK(usual.longest_item <= 500);
  const SquareCounts longer =
      counts_of(renderer, renderer.backend().upload(layers(9000, 0.004, 0.0055)), camera);
  CHECK(longer.pieces > 64);
  CHECK(longer.pixels_joined > 32 * longer.pieces);
  CHECK(longer.pixels_joined <= 64 * longer.pieces);
  CHECK(longer.longest_item >= 1024);
  CHECK(longer.longest_item < 8500);  // what one walk leaves, another block takes up
}
