// SPDX-License-Identifier: Apache-2.0

// Tints of placed scenes.
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/contribution.hpp>
#include <swiftgs/reference.hpp>

#include "policies/placed_list.hpp"
#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::tint_test {

namespace {

constexpr int channels = 2;
constexpr float largest = std::numeric_limits<float>::max();

/// Some colours below 0, and every seventh beyond the range of float: those Gaussians are colourless.
Scene scene_of_extremes(std::size_t count, std::uint64_t seed) {
  Scene scene = with_features(random_scene(count, 3, seed), channels);
  for (std::size_t i = 0; i < count; i += 3) scene.sh0[i] *= 5.0f;
  for (std::size_t i = 0; i < count; i += 7) scene.sh0[i] = vec3(largest);
  for (std::size_t i = 0; i < count; i += 7)
    for (std::size_t k = 0; k < 45; ++k) scene.sh_rest[45 * i + k] = i % 2 == 0 ? largest : -largest;
  return scene;
}

}  // namespace

TEST_CASE("tint: a mix of finite colours is finite, and at an amount of 1 the tint's colour") {
  Random random(1);
  for (int i = 0; i < 100'000; ++i) {
    const auto colour = [&] {
      return vec3(random.f(0, 1) < 0.75f ? random.f(0, 2) : largest, float(random.scale(1e-44, 3e38)),
                  largest);
    };
    Tint tint{colour(), random.f(0, 1)};
    const vec3 from = colour(), mixed = tint.mixed_into(from);
    for (int c = 0; c < 3; ++c) {
      const double amount = double(tint.amount);
      const double exact = (1 - amount) * double(from[c]) + amount * double(tint.colour[c]);
      REQUIRE(std::isfinite(mixed[c]));
      REQUIRE(std::abs(double(mixed[c]) - exact) <= 0x1p-22 * exact + 0x1p-148);
    }
    tint.amount = 1;
    REQUIRE(tint.mixed_into(from) == tint.colour);
  }
}

SWIFTGS_CONTRACT("tint: an amount of 1 shows exactly the colour, whatever the harmonics") {
  Usual<B> renderer(test::make_backend<B>());
  const Scene scene = random_scene(800, 3, 2);
  const auto uploaded = backend.upload(scene);
  Scene grey = scene;
  grey.sh_degree = 0, grey.sh_rest.clear(), grey.sh0.assign(grey.size(), vec3(0));  // 0.5 from everywhere
  const Camera camera = turned_camera(90, 70, 0.1, 0.2);
  const auto draw = [&](const vec3& colour) {
    return renderer.render(std::vector<PlacedScene>{{.scene = uploaded.view(), .tint = {colour, 1}}}, camera);
  };
  const Frame expected = renderer.render(backend.upload(grey), camera), found = draw(vec3(0.5f));
  CHECK(same_planes(found, expected));
  // Products with powers of 2 are exact, so colours show that each channel has its own.
  const Frame channels_apart = draw(vec3(0.25f, 0, 64));
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < found.colour.size(); i += 3) {
    wrong += channels_apart.colour[i] != 0.5f * found.colour[i];
    wrong += channels_apart.colour[i + 1] != 0;
    wrong += channels_apart.colour[i + 2] != 128 * found.colour[i + 2];
  }
  CHECK(wrong == 0);
}

SWIFTGS_CONTRACT("tint: colours are those of the reference for each SH degree") {
  Usual<B> renderer(test::make_backend<B>());
  const Camera camera = turned_camera(80, 60, 0.1, 0.2);
  for (const int degree : {3, 2, 1, 0}) {
    Scene scene = random_scene(400, degree, 3), other = random_scene(300, 1, 4);
    for (std::size_t i = 0; i < scene.size(); i += 2) scene.sh0[i] *= 4.0f;  // many below 0, which are cut
    const List list{{.scene = scene, .tint = {vec3(0.1f, 1, 2), 0.3f}},
                    {.scene = other, .tint = {vec3(0), 0.9f}}};
    const ListOn on(backend, list);
    const std::vector<ReferenceScene> of_reference = for_reference(list);
    const ReferenceFrame expected = render_reference(span_of(of_reference), camera, {}, dvec3(0.0));
    const Frame frame = renderer.render(on.placed, camera, {});
    double sum = 0;
    for (std::size_t i = 0; i < frame.colour.size(); ++i)
      sum += std::abs(double(frame.colour[i]) - expected.colour[i]);
    CHECK(sum <= 5e-6 * double(frame.colour.size()));
  }
}

SWIFTGS_CONTRACT(
    "tint: colours alone change, and Gaussians stay colourless whose own colours are not finite") {
  Usual<B> renderer(test::make_backend<B>());
  const auto uploaded = backend.upload(scene_of_extremes(900, 5));
  const Camera camera = turned_camera(90, 70, 0.1, 0.2);
  const RenderSettings settings = settings_of_all(channels);
  const Frame alone = renderer.render(uploaded, camera, settings);
  Scene finite = random_scene(900, 3, 5);
  CHECK(renderer.render(backend.upload(finite), camera, settings_of_all()).alpha != alone.alpha);
  for (const float amount : {0.25f, 1.0f}) {
    const std::vector<PlacedScene> placed{
        {.scene = uploaded.view(), .tint = {vec3(0.7f, 0.1f, 0.4f), amount}}};
    CHECK_FALSE(placed[0].is_plain());
    CHECK(PlacedScene{.tint = {vec3(0.7f, 0.1f, 0.4f), -0.0f}}.is_plain());
    Frame found = renderer.render(placed, camera, settings);
    CHECK(found.colour != alone.colour);
    found.colour = alone.colour;
    CHECK(same_planes(found, alone));
    Contributions<B> tinted(placed, test::make_backend<B>());
    Contributions<B> plain(std::vector<PlacedScene>{{uploaded.view()}}, test::make_backend<B>());
    tinted.add(camera, {}), plain.add(camera, {});
    CHECK(tinted.sums() == plain.sums());
  }
}

}  // namespace swiftgs::test::tint_test
