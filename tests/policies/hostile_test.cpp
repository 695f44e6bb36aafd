// SPDX-License-Identifier: Apache-2.0

/// @file
/// Frames that are rendered on a thread with another floating-point environment than the default one.

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <string_view>
#include <type_traits>

#include <doctest/doctest.h>

#include <swiftgs/metrics.hpp>

#include "policies/rasterizers.hpp"
#include "support/environment.hpp"

namespace swiftgs::test::hostile_test {

namespace {

/// An ordinary scene with needles, giants, and numbers that are denormal or nearly so.
Scene hostile_scene() {
  Scene scene = random_scene(300, 3, 1);
  Random random(2);
  const float denormal = std::numeric_limits<float>::denorm_min(), least = std::numeric_limits<float>::min();
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (i % 10 == 0) scene.scales[i] = vec3{random.f(1, 30), random.f(1e-6, 1e-3), random.f(1e-6, 1e-3)};
    if (i % 10 == 1) scene.scales[i] = vec3(denormal, 1e-20f, 0.5f);
    if (i % 10 == 2) scene.scales[i] = vec3(1e10f, 0.5f, 1e-10f);
    if (i % 10 == 3) scene.means[i].x = denormal, scene.means[i].y = -least / 3;
    if (i % 10 == 4) scene.opacities[i] = i % 20 == 4 ? denormal : 1.0f;
    if (i % 10 == 5) scene.rotations[i] = {1, denormal, -least / 2, least};
    if (i % 10 == 6) scene.sh0[i] = vec3(denormal, -denormal, least);
    if (i % 10 == 7) scene.means[i].z = i % 20 == 7 ? denormal : 0.01f;
  }
  return scene;
}

/// How frames are rendered.
struct Way {
  Environment environment;
  bool made_inside = false;  ///< whether renderers are made in the environment too
  int threads = 1;           ///< of `Cpu`
  bool antialiased = false;
};

template <class B>
B make(const Way& way) {
  if constexpr (std::is_same_v<B, Cpu>)
    return Cpu(way.threads);
  else
    return B();
}

/// The frame of a renderer that has drawn one before, in the default environment, or was made for this one.
template <class R, class B>
Frame draw(const Way& way, const Scene& scene) {
  const Camera camera = forward_camera(83, 50);
  RenderSettings settings;
  settings.background = vec3(0.2f, 0.3f, 0.4f), settings.outputs = {true, true};
  settings.conventions.antialiased = way.antialiased;
  R outside(make<B>(way));
  const auto uploaded = outside.backend().upload(scene);
  if (!way.made_inside) outside.render(uploaded, camera, settings);
  const ScopedEnvironment scope(way.environment);
  if (!way.made_inside) return outside.render(uploaded, camera, settings);
  R inside(make<B>(way));
  return inside.render(uploaded, camera, settings);
}

/// Renders with every rasterizer, two sorts and both conservative bounds. All images of a rasterizer must be
/// finite and the same.
template <class B>
std::map<std::string_view, Frame> draw_all(const Way& way) {
  CAPTURE(way.environment.name);
  CAPTURE(way.made_inside);
  CAPTURE(way.antialiased);
  const Scene scene = hostile_scene();
  std::map<std::string_view, Frame> frames;
  const auto draw_with = [&]<class Sort, class Raster, class Bounds>(Sort, Raster, Bounds) {
    using R = Renderer<B, Sort, Raster, Bounds>;
    CAPTURE(R::name);
    const Frame frame = draw<R, B>(way, scene);
    CHECK(is_finite(frame));
    CHECK(same_planes(frames.try_emplace(Raster::name, frame).first->second, frame));
  };
  for_each_raster([&](auto raster) {
    draw_with(StandardSort(), raster, OpacityBox());
    draw_with(StandardSort(), raster, Ellipse());
    draw_with(EarlySort(), raster, OpacityBox());
    draw_with(EarlySort(), raster, Ellipse());
  });
  return frames;
}

/// Checks what holds between the frames of one way to render, and those of `usual`, the default environment.
template <class B>
void check_way(Way way, const std::map<std::string_view, Frame>& usual) {
  const std::map<std::string_view, Frame> frames = draw_all<B>(way);
  CHECK(frames.size() == 7);
  CAPTURE(way.environment.name);
  const bool to_nearest = way.environment.rounding == FE_TONEAREST;
  for (const auto& named : frames) {
    const std::string_view name = named.first;
    const Frame &frame = named.second, &expected = usual.at(name);
    CAPTURE(name);
    // `Cpu` rounds to nearest whatever the mode is.
    if (to_nearest || std::is_same_v<B, Serial>) CHECK(same_planes(frame, expected) == to_nearest);
    // A sum of squares cancels nothing, so rounding moves it little.
    if (name.find("cholesky") != std::string_view::npos) {
      CHECK(psnr(frame.colour, expected.colour) > 125);
      CHECK(max_abs_difference(frame.colour, expected.colour) <= 1e-5);
    }
    CHECK(std::count_if(frame.alpha.begin(), frame.alpha.end(), [](float a) { return a > 0.1f; }) > 400);
  }
  if constexpr (std::is_same_v<B, Cpu>) {
    way.threads = 4;
    for (const auto& named : draw_all<Cpu>(way)) CHECK(same_planes(named.second, frames.at(named.first)));
  }
}

}  // namespace

TEST_CASE_TEMPLATE(
    "hostile: images are finite and independent of sort and bounds and threads in every environment", B,
    SWIFTGS_TEST_HOSTS) {
  for (const bool antialiased : {false, true}) {
    const auto usual = draw_all<B>({.environment = environments[0], .antialiased = antialiased});
    for (const Environment& environment : environments)
      for (const bool made_inside : {false, true})
        check_way<B>({environment, made_inside, 1, antialiased}, usual);
  }
}

TEST_CASE("hostile: the environment is in force while it is set and gone afterwards") {
  volatile float one = 1, tiny = 0x1p-30f, least = std::numeric_limits<float>::min(), half = 0.5f;
  {
    const ScopedEnvironment scope(environments[1]);
    CHECK(one + tiny > 1);
  }
  CHECK(one + tiny == 1);
#if defined(__SSE__)
  {
    const ScopedEnvironment scope(environments[4]);
    CHECK(least * half == 0);
  }
#endif
  CHECK(least * half > 0);
}

}  // namespace swiftgs::test::hostile_test
