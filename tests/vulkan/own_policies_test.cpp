// SPDX-License-Identifier: Apache-2.0

// Policies of a program's own on `Vulkan`, whose shaders it brings, against the same on `Serial`.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <diamond_shaders.hpp>
#include <doctest/doctest.h>
#include <even_rows_shaders.hpp>

#include <swiftgs/metrics.hpp>
#include <swiftgs/swiftgs.hpp>

#include "device_state.hpp"
#include "policies/images.hpp"
#include "vulkan/device.hpp"
#include "vulkan/frames.hpp"

namespace swiftgs::test {
namespace {

/// s = (|u| + |v|)^2: a splat shows a rhomb within its ellipse.
struct Diamond {
  static constexpr std::string_view name = "diamond";
  struct X {
    float p;
  };
  struct Y {
    float q, v;
  };

  Diamond(const SplatShape& s, vec2) : shape_(s) {}
  X x_term(float at) const { return {shape_.l0 * shape_.right_of_mean(at)}; }
  Y y_term(float at) const {
    const float dy = shape_.below_mean(at);
    return {shape_.l1 * dy, shape_.l2 * dy};
  }
  static float exponent(X x, Y y) {
    const float around = std::fabs(x.p + y.q) + std::fabs(y.v);
    return around * around;
  }

 private:
  const SplatShape& shape_;
};
static_assert(ExponentPolicy<Diamond>);
using Diamonds = AxisSharedThreshold<Diamond>;
static_assert(vulkan::PolicyOfProgram<Diamonds> && !vulkan::PolicyOfProgram<AxisSharedThreshold<FloatSplit>>);
static_assert(vulkan::PolicyOfProgram<EvenRows> && !vulkan::PolicyOfProgram<Ellipse>);

/// A sort of stages of the library.
struct NearestFirst {
  static constexpr std::string_view name = "nearest-first";
  template <class B>
  using Scratch = EarlySort::Scratch<B>;

  template <class B, class Bounds>
  void build(B& b, const SortJob& job, const Bounds& bounds, Scratch<B>& scratch, TileLists<B>& lists) {
    group_by_tile(b, job, bounds, order_by_depth(b, job.splats, scratch.depths), scratch.group, lists);
  }
};

/// Even rows by code that a test replaces.
struct Replaced : EvenRows {
  static constexpr std::string_view name = "replaced";
};
vulkan::BoundsShaders replaced_shaders;

}  // namespace
}  // namespace swiftgs::test

template <>
inline constexpr const auto* swiftgs::vulkan::shaders<swiftgs::test::EvenRows> = &even_rows_shaders;
template <>
inline constexpr const auto* swiftgs::vulkan::shaders<swiftgs::test::Diamonds> = &diamond_shaders;
template <>
inline constexpr const swiftgs::vulkan::BoundsShaders* swiftgs::vulkan::shaders<swiftgs::test::Replaced> =
    &swiftgs::test::replaced_shaders;

namespace swiftgs::test {

SWIFTGS_VULKAN_CASE("vulkan: bounds and a sort of a program list what they list on Serial") {
  // Some splats have a mask, some span too many tiles for one.
  SplatSet splats = random_splats(600, 300, 200, 8);
  splats.add(make_splat(150, 100, 90, 30, 0.5, 1), 1.5f);
  splats.add(make_splat(30'000, 30'000, 1e6, 1e6, 0, 1), 2.5f);
  Serial serial;
  const HostLists expected =
      host_lists(serial, build_lists<NearestFirst, EvenRows>(serial, splats.job(300, 200)));
  Vulkan b;
  const SplatsOn<Vulkan> there(b, splats);
  CHECK(host_lists(b, build_lists<NearestFirst, EvenRows>(b, there.job(300, 200))) == expected);
  CHECK(host_lists(b, build_lists<NearestFirst, OpacityBox>(b, there.job(300, 200))) != expected);
}

SWIFTGS_VULKAN_CASE("vulkan: a rasterizer and bounds of a program draw what they draw on Serial") {
  RenderSettings settings;
  settings.outputs.alpha = settings.outputs.depth = true, settings.count = true;
  Renderer<Vulkan, NearestFirst, Diamonds, EvenRows> renderer;
  Renderer<Serial, NearestFirst, Diamonds, EvenRows> serial;
  const auto check = [&](const Scene& scene, const Camera& camera) {
    const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
    const Frame expected = serial.render(serial.backend().upload(scene), camera, settings);
    CHECK(max_abs_difference(frame.colour, expected.colour) < 2e-6);
    CHECK(max_abs_difference(frame.alpha, expected.alpha) < 2e-6);
    CHECK(max_abs_difference(frame.depth, expected.depth) < 1e-3);
    CHECK(renderer.statistics().intersections == serial.statistics().intersections);
    CHECK(renderer.statistics().raster.contributing_pairs > 0);
    return expected;
  };
  Scene scene = random_scene(4000, 1, 21);
  const Camera camera = forward_camera(75, 45);
  const Frame diamonds = check(scene, camera);
  Renderer<Serial, NearestFirst, AxisSharedThreshold<FloatCholesky>, EvenRows> ellipses;
  const Frame other = ellipses.render(ellipses.backend().upload(scene), camera, settings);
  CHECK(max_abs_difference(other.colour, diamonds.colour) > 0.05);
  // All in one tile, whose list is long.
  Random random(22);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const float z = 2 + 8 * random.f(0, 1);
    scene.means[i] = vec3(random.f(-0.3, 0.3) * z, random.f(-0.3, 0.3) * z, z);
    scene.scales[i] = vec3(random.f(0.05, 0.4) * z, random.f(0.05, 0.4) * z, 0.01f);
    scene.opacities[i] = 0.006f;
  }
  const auto kernels = renderer.backend().profile([&] { check(scene, forward_camera(16, 16)); });
  CHECK(std::any_of(kernels.begin(), kernels.end(), [](const auto& k) { return k.name == "raster_long"; }));
}

SWIFTGS_VULKAN_CASE("vulkan: shaders of policies are told apart and damaged or other ones are refused") {
  Vulkan b;
  const SplatSet splats = random_splats(50, 60, 40, 8);
  const SplatsOn<Vulkan> there(b, splats);
  const auto message = [&] {
    try {
      build_lists<NearestFirst, Replaced>(b, there.job(60, 40));
    } catch (const InvalidArgument& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const auto refused = [](std::string_view kernel, std::string_view found) {
    const std::string expected(std::string(kernel) + '-' + std::string(version));
    return "vulkan: the shaders of replaced have " + std::string(found) + " for the kernel " +
           std::string(kernel) + ", expected " + expected +
           " as swiftgs_add_shaders of this version compiles it";
  };
  const std::string nothing = refused("footprints", "no SPIR-V of a compute shader");
  CHECK(message() == nothing);
  replaced_shaders = even_rows_shaders;
  std::vector<std::uint32_t> words(even_rows_shaders.footprints.begin(), even_rows_shaders.footprints.end());
  const auto replace = [&](std::size_t size) { replaced_shaders.footprints = {words.data(), size}; };
  replace(words.size() - 1);
  CHECK(message() == nothing);
  words[0] ^= 1, replace(words.size());
  CHECK(message() == nothing);
  words[0] ^= 1, words[5] = 0;  // an instruction without words
  CHECK(message() == nothing);
  replaced_shaders.footprints = even_rows_shaders.emit;
  CHECK(message() == refused("footprints", "the entry point emit-" + std::string(version)));
  replaced_shaders = even_rows_shaders;
  CHECK(message().empty());

  const auto pipeline = [&]<class Bounds>(const Bounds&) {
    const vulkan::BoundsKind kind = vulkan::bounds_kind<Bounds>;
    return VulkanDevice::own().state().pipeline(
        {vulkan::Kernel::footprints, kind, &vulkan::BoundsShaders::footprints}, 128, {kind.number});
  };
  CHECK(pipeline(Replaced()) == pipeline(Replaced()));
  CHECK(pipeline(Replaced()) != pipeline(EvenRows()));
  CHECK(pipeline(EvenRows()) != pipeline(ThreeSigmaSquare()));
}

}  // namespace swiftgs::test
