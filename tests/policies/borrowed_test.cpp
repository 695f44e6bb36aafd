// SPDX-License-Identifier: Apache-2.0

// Arrays of the caller that are drawn where they lie, against their copies.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/metrics.hpp>

#include "policies/arrays_on.hpp"
#include "policies/hooked.hpp"
#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::borrowed_test {

namespace {

constexpr int channels = 5;
constexpr std::size_t count = 1000;

/// A row of floats a Gaussian: mean, scale, opacity, rotation, features, coefficients, and `gap` floats.
/// Rotations have any length, 0 among them.
struct Rows {
  Rows(const Scene& scene, std::size_t gap)
      : degree(scene.sh_degree), coefficients(3 + 3 * std::size_t(sh_rest_count(degree))) {
    stride = 11 + channels + coefficients + gap;
    // What nothing may read.
    floats.assign(1 + stride * (count - 1) + 11 + channels + coefficients, NAN);
    Random random(3);
    for (std::size_t i = 0; i < count; ++i) {
      float* to = &floats[1 + stride * i];
      const auto put = [&](const float* from, std::size_t size) { to = std::copy_n(from, size, to); };
      const Quaternion q = scene.rotations[i];
      const float length = i == 7 ? 0 : std::exp(random.f(-20, 20));
      const float rotation[] = {length * q.w, length * q.x, length * q.y, length * q.z};
      put(&scene.means[i].x, 3), put(&scene.scales[i].x, 3), put(&scene.opacities[i], 1);
      put(rotation, 4), put(&scene.features[channels * i], channels);
      put(&scene.sh0[i].x, 3), put(scene.sh_rest.data() + (coefficients - 3) * i, coefficients - 3);
    }
  }

  /// `at` holds `floats`.
  SceneArrays arrays(const float* at) const {
    const auto column = [&](std::size_t i) {
      return FloatArray{at + 1 + i, std::ptrdiff_t(stride * sizeof(float))};
    };
    SceneArrays all{.count = count, .sh_degree = degree, .feature_channels = channels, .any_rotations = true};
    all.means = column(0), all.scales = column(3), all.opacities = column(6), all.rotations = column(7);
    all.features = column(11), all.sh0 = column(11 + channels);
    if (degree > 0) all.sh_rest = column(14 + channels);
    return all;
  }

  int degree;
  std::size_t coefficients, stride = 0;
  std::vector<float> floats;
};

Scene scene_of(int degree) { return with_features(random_scene(count, degree, 3), channels); }

}  // namespace

SWIFTGS_CONTRACT("borrowed: arrays of any stride have the bits of their copies in every plane") {
  Usual<B> renderer(test::make_backend<B>());
  std::optional<typename B::SceneOn> none;
  for (int degree = 0; degree <= max_sh_degree; ++degree)
    // Coefficients begin 0 to 3 floats behind a multiple of 16 bytes, for all Gaussians or not.
    for (const std::size_t gap : {0, 1, 2, 3, 4, 5}) {
      CAPTURE(degree);
      CAPTURE(gap);
      const Rows rows(scene_of(degree), gap);
      const auto memory = to_backend(backend, rows.floats);
      for (const bool plain : {false, true}) {
        SceneArrays arrays = rows.arrays(memory.data());
        arrays.plain_colours = plain;
        const SceneView borrowed = view(arrays);
        const auto copy = backend.upload(arrays, none);
        const RenderSettings settings = settings_of_all(channels);
        check_same<B>(renderer, borrowed, copy, settings);
        const std::vector<Camera> all = cameras_around();
        std::vector<Frame> some(all.size()), expected(all.size());
        renderer.render(borrowed, span_of(all), settings, span_of(some));
        renderer.render(copy, span_of(all), settings, span_of(expected));
        for (std::size_t i = 0; i < some.size(); ++i) CHECK(same_planes(some[i], expected[i]));
      }
    }
}

SWIFTGS_CONTRACT("borrowed: bands side by side, as tensors have them, are drawn to any lower degree") {
  Usual<B> renderer(test::make_backend<B>());
  std::optional<typename B::SceneOn> none;
  for (int stored = 1; stored <= max_sh_degree; ++stored) {
    const Scene scene = scene_of(stored);
    const std::size_t each = 3 * std::size_t(sh_rest_count(stored)), row = each + 3;
    std::vector<float> bands(row * count);
    for (std::size_t i = 0; i < count; ++i) {
      std::copy_n(&scene.sh0[i].x, 3, &bands[row * i]);
      std::copy_n(&scene.sh_rest[each * i], each, &bands[row * i + 3]);
    }
    const auto sh = to_backend(backend, bands);
    const ArraysOn<B> dense(backend, scene);
    for (int degree = 0; degree <= stored; ++degree) {
      CAPTURE(stored);
      CAPTURE(degree);
      SceneArrays arrays = dense.all;
      arrays.sh_degree = degree;
      arrays.sh0 = {sh.data(), std::ptrdiff_t(row * sizeof(float))};
      arrays.sh_rest = {sh.data() + 3, std::ptrdiff_t(row * sizeof(float))};
      const auto copy = backend.upload(arrays, none);
      check_same<B>(renderer, view(arrays), copy);
      // Placed too, with warps that see several scenes.
      std::vector<PlacedScene> placed, expected;
      for (std::size_t first = 0; first + 50 <= count; first += 50) {
        placed.push_back({.scene = range_of(view(arrays), first, 50)});
        expected.push_back({.scene = range_of(copy.view(), first, 50)});
      }
      CHECK(same_planes(renderer.render(placed, cameras_around()[0], {}),
                        renderer.render(expected, cameras_around()[0], {})));
    }
  }
}

SWIFTGS_CONTRACT("borrowed: quaternions of any length turn as unit ones do") {
  Usual<B> renderer(test::make_backend<B>());
  const Scene scene = scene_of(1);
  const Frame expected = renderer.render(backend.upload(scene), cameras_around()[0], {});
  for (const double length : {1e-38, 1e-25, 0.5, 3.0, 1e25, 1e38}) {
    CAPTURE(length);
    Scene longer = scene;
    for (Quaternion& q : longer.rotations)
      q = {float(length * q.w), float(length * q.x), float(length * q.y), float(length * q.z)};
    ArraysOn<B> arrays(backend, longer);
    arrays.all.any_rotations = true;
    CHECK(psnr(renderer.render(arrays.view(), cameras_around()[0], {}).colour, expected.colour) > 90);
  }
}

SWIFTGS_CONTRACT("borrowed: a rotation of zeros is drawn as the identity, copied or not") {
  Usual<B> renderer(test::make_backend<B>());
  Scene zeros = scene_of(1), unturned = zeros;
  for (std::size_t i = 0; i < count; i += 3) zeros.rotations[i] = {0, 0, 0, 0}, unturned.rotations[i] = {};
  ArraysOn<B> found(backend, zeros), expected(backend, unturned);
  std::optional<typename B::SceneOn> none;
  for (const bool any : {false, true}) {
    CAPTURE(any);
    found.all.any_rotations = expected.all.any_rotations = any;
    check_same<B>(renderer, found, expected);
    check_same<B>(renderer, backend.upload(found.all, none), backend.upload(expected.all, none));
  }
}

SWIFTGS_CONTRACT("borrowed: a Gaussian with a number that is not finite is not drawn") {
  Usual<B> renderer(test::make_backend<B>());
  const Scene scene = scene_of(2);
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    Scene without = scene, with = scene;
    for (std::size_t i = 0; i < count; i += 7) without.opacities[i] = 0;
    for (std::size_t i = 0; i < count; i += 7) {
      float* const of[] = {&with.means[i].x,   &with.scales[i].y, &with.rotations[i].z,
                           &with.opacities[i], &with.sh0[i].x,    &with.sh_rest[24 * i + 5]};
      *of[i / 7 % 6] = bad;
    }
    ArraysOn<B> found(backend, with), expected(backend, without);
    for (const bool any : {false, true}) {
      found.all.any_rotations = expected.all.any_rotations = any;
      check_same<B>(renderer, found, expected);
    }
  }
}

TEST_CASE("borrowed: what frames do not read is refused") {
  const Rows rows(scene_of(1), 0);
  const SceneArrays good = rows.arrays(rows.floats.data());
  const auto refused = [&](auto spoil, const char* message) {
    SceneArrays arrays = good;
    spoil(arrays);
    CHECK_THROWS_WITH_AS((void)view(arrays), doctest::Contains(message), std::invalid_argument);
  };
  const char* const raw = "scene: log_scales or logit_opacities is set, expected neither";
  refused([](SceneArrays& a) { a.log_scales = true; }, raw);
  refused([](SceneArrays& a) { a.logit_opacities = true; }, raw);
  refused([](SceneArrays& a) { a.means.stride = std::ptrdiff_t(1) << 32; },
          "scene: means: stride is 4294967296 bytes, expected less than 2^32");
  refused([](SceneArrays& a) { a.means.stride = 8; }, "scene: means: stride is 8 bytes");
  refused([](SceneArrays& a) { a.sh_rest.data = nullptr; }, "scene: sh_rest is null");
  refused([](SceneArrays& a) { a.features.stride = 16; },
          "features: stride is 16 bytes, expected 0 or a multiple of 4 from 20");
  refused([](SceneArrays& a) { a.features = {}; }, "features is null, expected a pointer");
  refused([](SceneArrays& a) { a.feature_channels = -1; }, "feature_channels is -1, expected 0 or more");
  CHECK(view(SceneArrays{}).size() == 0);
}

SWIFTGS_CONTRACT("borrowed: a renderer by name draws the arrays as they are now") {
  const std::string name = std::string(B::name) + "/adaptive/axis-shared-float-split/ellipse";
  const std::unique_ptr<AnyRenderer> renderer = make_renderer(name), copying = make_renderer(name);
  const Rows rows(scene_of(2), 1);
  auto memory = to_backend(backend, rows.floats);
  const SceneArrays arrays = rows.arrays(memory.data());
  const auto draws_them = [&] {
    copying->set_scene(arrays);
    Frame found, expected;
    renderer->render(cameras_around()[0], settings_of_all(channels), found);
    copying->render(cameras_around()[0], settings_of_all(channels), expected);
    return same_planes(found, expected);
  };
  renderer->borrow_scene(arrays);
  CHECK(draws_them());
  std::vector<float> moved = rows.floats;
  for (std::size_t i = 0; i < count; ++i) moved[1 + rows.stride * i] += 0.25f;
  CopyToBackend<B>::copy(Span<const float>{moved.data(), moved.size()}, memory.data());
  CHECK(draws_them());
  CHECK_THROWS_WITH_AS(renderer->update_scene(0, 0, arrays),
                       doctest::Contains("update: the scene's arrays are the caller's"),
                       std::invalid_argument);
}

}  // namespace swiftgs::test::borrowed_test
