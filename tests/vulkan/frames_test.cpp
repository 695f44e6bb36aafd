// SPDX-License-Identifier: Apache-2.0

// Frames of `Vulkan` against those of `Serial` and of the reference.
#include "vulkan/frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/contribution.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/images.hpp"
#include "policies/lenses.hpp"
#include "policies/random_splats.hpp"
#include "vulkan/device.hpp"

namespace swiftgs::test {
namespace {

/// Share of pixels whose picks are other ones, where two splats weigh nearly the same. 0 of planes not drawn.
double other_picks(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  REQUIRE(a.size() == b.size());
  std::size_t other = 0;
  for (std::size_t i = 0; i < a.size(); ++i) other += a[i] != b[i];
  return double(other) / double(std::max<std::size_t>(a.size(), 1));
}

/// Share of pixels whose depths are those of another splat.
double other_depths(const std::vector<float>& a, const std::vector<float>& b) {
  REQUIRE(a.size() == b.size());
  std::size_t other = 0;
  for (std::size_t i = 0; i < a.size(); ++i) other += !(std::fabs(a[i] - b[i]) < 1e-3f);
  return double(other) / double(std::max<std::size_t>(a.size(), 1));
}

/// Holds `frame` to that of `Serial`: kernels round exponentials, by 2.5 units in the last place where the
/// device's own serve, and sums in their own way.
void check_like(const Frame& frame, const Frame& serial) {
  CHECK(max_abs_difference(frame.colour, serial.colour) < 2e-6);
  CHECK(max_abs_difference(frame.alpha, serial.alpha) < 2e-6);
  CHECK(max_abs_difference(frame.depth, serial.depth) < 1e-3);
  CHECK(other_depths(frame.first_depth, serial.first_depth) < 1e-3);
  CHECK(other_depths(frame.median_depth, serial.median_depth) < 1e-3);
  CHECK(other_picks(frame.id, serial.id) < 1e-3);
  CHECK(other_picks(frame.median_id, serial.median_id) < 1e-3);
}

}  // namespace

SWIFTGS_VULKAN_CASE("vulkan: frames are as near to the reference as those of Serial and repeat their bits") {
  UsualVulkan renderer;
  UsualSerial serial;
  const Camera camera = builtin_camera(320, 180);
  for (const std::size_t gaussians : {2000, 20000, 200000}) {
    CAPTURE(gaussians);
    const auto scene = std::make_shared<const Scene>(make_builtin_scene(gaussians));
    const VulkanScene there = renderer.backend().upload(scene);
    const Frame frame = renderer.render(there, camera);
    const auto reference = render_reference(*scene, camera, Conventions()).colour;
    const double here = psnr(frame.colour, reference);
    const double of_serial = psnr(serial.render(serial.backend().upload(scene), camera).colour, reference);
    MESSAGE(gaussians, " Gaussians: ", here, " dB, Serial ", of_serial, " dB");
    CHECK(here > of_serial - 2);
    CHECK(same_planes(renderer.render(there, camera), frame));
    UsualVulkan other;
    CHECK(same_planes(other.render(there, camera), frame));
  }
}

SWIFTGS_VULKAN_CASE("vulkan: a frame has bits that are the same at other sizes of subgroups") {
  UsualVulkan renderer;
  RenderSettings settings;
  settings.outputs.alpha = settings.outputs.depth = true;
  const Frame frame =
      renderer.render(renderer.backend().upload(random_scene(3000, 1, 5)), forward_camera(150, 90), settings);
  std::uint64_t hash = 14695981039346656037u;
  for (const auto* plane : {&frame.colour, &frame.alpha, &frame.depth})
    for (const float value : *plane)
      hash = (hash ^ __builtin_bit_cast(std::uint32_t, value)) * 1099511628211u;
  MESSAGE("bits of a frame: ", hash);  // widths.cmake compares them
  CHECK(frame.colour.size() == 3 * 150 * 90);
}

SWIFTGS_VULKAN_CASE("vulkan: each rasterizer has the planes that Serial has") {
  const auto scene = std::make_shared<const Scene>(random_scene(3000, 3, 5));
  const Camera camera = forward_camera(150, 90);
  const RenderSettings settings = with_planes();
  for_each_type(AllRasters(), [&]<class Raster>(const Raster&) {
    CAPTURE(Raster::name);
    Renderer<Vulkan, EarlySort, Raster, Ellipse> renderer;
    Renderer<Serial, EarlySort, Raster, Ellipse> serial;
    const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
    const Frame expected = serial.render(serial.backend().upload(scene), camera, settings);
    if (Raster::name.ends_with("half-split"))  // a splat between two boxes shows where its exponent errs
      CHECK(psnr(frame.colour, expected.colour) > 30);
    else
      check_like(frame, expected);
  });
}

SWIFTGS_VULKAN_CASE("vulkan: conservative bounds and sorts change no bit") {
  const auto scene = std::make_shared<const Scene>(random_scene(5000, 1, 6));
  const Camera camera = forward_camera(200, 120);
  UsualVulkan usual;
  const VulkanScene there = usual.backend().upload(scene);
  const Frame expected = usual.render(there, camera, with_planes());
  for_each_type(AllBounds(), [&]<class Bounds>(const Bounds&) {
    CAPTURE(Bounds::name);
    Renderer<Vulkan, EarlySort, AxisSharedThreshold<FloatCholesky>, Bounds> renderer;
    const Frame frame = renderer.render(there, camera, with_planes());
    CHECK(same_planes(frame, expected) == Bounds::conservative);
  });
  Renderer<Vulkan, StandardSort> standard;
  CHECK(same_planes(standard.render(there, camera, with_planes()), expected));
  Renderer<Vulkan, AdaptiveSort> adaptive;
  for (int frame = 0; frame < 12; ++frame)
    CHECK(same_planes(adaptive.render(there, camera, with_planes()), expected));
  CHECK(adaptive.sort_decided());
}

SWIFTGS_VULKAN_CASE("vulkan: several views of placed scenes are drawn as Serial draws them") {
  const auto first = std::make_shared<const Scene>(random_scene(2000, 2, 7));
  const auto second = std::make_shared<const Scene>(random_scene(1500, 0, 8));
  Placement moved{.scene = 1};
  moved.world_from_scene.scale = 0.5, moved.world_from_scene.translation = dvec3(0.5, -0.25, 3);
  moved.opacity = 0.75f, moved.tint = {vec3(1, 0.5f, 0), 0.5f};
  moved.clip = Clip::box(vec3(-2, -2, -1), vec3(3, 2, 8));
  const Placement placements[] = {{.scene = 0}, moved};
  const Camera cameras[] = {forward_camera(120, 70), forward_camera(57, 83), forward_camera(64, 64, 40)};
  const auto draw = [&](AnyRenderer& renderer, Frame(&frames)[3]) {
    renderer.set_scene(first), renderer.add_scene(second);
    renderer.place({placements, 2});
    renderer.render({cameras, 3}, with_planes(), {frames, 3});
  };
  UsualVulkan renderer;
  UsualSerial serial;
  Frame found[3], expected[3];
  draw(renderer, found), draw(serial, expected);
  for (int i = 0; i < 3; ++i) check_like(found[i], expected[i]);
}

SWIFTGS_VULKAN_CASE("vulkan: harmonics in fewer bytes are drawn as Serial draws them") {
  for (const HarmonicsKept kept : {HarmonicsKept::floats, HarmonicsKept::smallest, HarmonicsKept::halves}) {
    Scene scene = random_scene(1000, 3, 9);
    for (float& c : scene.sh_rest)  // bytes hold multiples of a power of two
      if (kept == HarmonicsKept::smallest) c = std::round(c * 64) / 64;
    const Camera camera = forward_camera(100, 60);
    UsualVulkan renderer;
    UsualSerial serial;
    check_like(renderer.render(renderer.backend().upload(scene, kept), camera, with_planes()),
               serial.render(serial.backend().upload(Scene(scene), kept), camera, with_planes()));
  }
}

SWIFTGS_VULKAN_CASE("vulkan: features of several passes and converted colours are those of Serial") {
  const auto scene = std::make_shared<const Scene>(with_features(random_scene(1000, 0, 12), 21));
  const Camera camera = forward_camera(70, 50);
  UsualVulkan renderer;
  UsualSerial serial;
  RenderSettings settings;
  settings.background = vec3(0.25f, 0.5f, 0.125f);
  settings.outputs.features = 21, settings.outputs.normal = settings.outputs.squared_depth = true;
  settings.conventions.colours = ColourSpace::linear;
  const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
  const Frame expected = serial.render(serial.backend().upload(scene), camera, settings);
  CHECK(max_abs_difference(frame.colour, expected.colour) < 1e-5);
  CHECK(max_abs_difference(frame.features, expected.features) < 1e-5);
  CHECK(max_abs_difference(frame.normal, expected.normal) < 1e-5);
  CHECK(max_abs_difference(frame.squared_depth, expected.squared_depth) < 1e-2);
}

SWIFTGS_VULKAN_CASE(
    "vulkan: pixels of each format over an image and behind an occluder are those of Serial") {
  const int width = 61, height = 37;
  const auto scene = std::make_shared<const Scene>(random_scene(1500, 1, 10));
  const Camera camera = forward_camera(width, height);
  UsualVulkan renderer;
  UsualSerial serial;
  const VulkanScene there = renderer.backend().upload(scene);
  const auto here = serial.backend().upload(scene);
  Random random(3);
  std::vector<float> occluder(std::size_t(width) * height);
  for (float& value : occluder) value = random.f(0.2, 1);
  for (const PixelFormat format : {PixelFormat::rgb_float, PixelFormat::rgba_float, PixelFormat::rgba_half,
                                   PixelFormat::rgba_8, PixelFormat::bgra_8}) {
    CAPTURE(int(format));
    Image image(width, height, format);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) image.set(x, y, vec4(0.1f, 0.2f, 0.3f, 0.5f));
    VulkanBuffer<unsigned char> colours;
    VulkanBuffer<float> depths;
    colours.reset(image.bytes.size()), depths.reset(occluder.size());
    renderer.backend().write(image.bytes.data(), colours.data(), image.bytes.size());
    renderer.backend().write(occluder.data(), depths.data(), 4 * occluder.size());
    const auto draw = [&](auto& drawing, const auto& of, void* colour, const float* depth) {
      FrameView frame = image.frame();
      frame.colour.data = colour, frame.over = true;
      frame.occluder = {depth, std::ptrdiff_t(4 * width)};
      frame.stored_depth = StoredDepth::perspective(1, 10);
      drawing.render_into(of, camera, {}, frame);
    };
    draw(renderer, there, colours.data(), depths.data());
    Image found = image;
    renderer.backend().read(colours.data(), found.bytes.data(), found.bytes.size());
    draw(serial, here, image.bytes.data(), occluder.data());
    CHECK(found.kept_to_its_rows());
    float most = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 4; ++c) most = std::max(most, std::fabs(found.at(x, y)[c] - image.at(x, y)[c]));
    CHECK(most < (format <= PixelFormat::rgba_float  ? 2e-6f
                  : format == PixelFormat::rgba_half ? 1e-3f
                                                     : 4e-3f));
  }
}

SWIFTGS_VULKAN_CASE("vulkan: contributions are those of Serial but for roundings at thresholds") {
  const auto scene = std::make_shared<const Scene>(random_scene(2000, 1, 11));
  Contributions<Vulkan> found(scene);
  Contributions<Serial> expected(scene);
  for (const Camera& camera : {forward_camera(90, 60), forward_camera(64, 64, 40)}) {
    found.add(camera, {}), expected.add(camera, {});
    const std::vector<std::uint64_t> sums = found.sums(), wanted = expected.sums();
    REQUIRE(sums.size() == scene->size());
    double total = 0;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const double weight = weight_of_parts(wanted[i]);
      REQUIRE(std::fabs(weight_of_parts(sums[i]) - weight) <= 1e-4 * weight + 1.0 / 255);
      total += weight;
    }
    CHECK(total > 2000);
  }
}

SWIFTGS_VULKAN_CASE("vulkan: every lens is drawn as Serial draws it and chunks change no bit") {
  const auto scene = std::make_shared<const Scene>(make_builtin_scene(2000));
  UsualVulkan renderer;
  UsualSerial serial;
  const VulkanScene there = renderer.backend().upload(scene);
  SceneView without_chunks = there.view();
  REQUIRE_FALSE(without_chunks.chunks.empty());
  without_chunks.chunks = {};
  const auto here = serial.backend().upload(scene);
  RenderSettings settings;
  settings.outputs.alpha = settings.outputs.depth = true;
  for (const Camera& camera : cameras_of_lenses(96, 56)) {
    CAPTURE(name_of(camera.lens.model));
    for (const Conventions::DepthAt at : {Conventions::DepthAt::centre, Conventions::DepthAt::ray}) {
      settings.conventions.depth_at = at;
      check_like(renderer.render(there, camera, settings), serial.render(here, camera, settings));
    }
    Camera tele = camera;  // shows few chunks
    if (camera.lens.model != LensModel::equirectangular) tele.fx *= 8, tele.fy *= 8;
    CHECK(
        same_planes(renderer.render(there, tele, settings), renderer.render(without_chunks, tele, settings)));
  }
}

}  // namespace swiftgs::test
