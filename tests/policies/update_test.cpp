// SPDX-License-Identifier: Apache-2.0

// Uploaded scenes that change in place, against fresh uploads of the same Gaussians.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>

#include "policies/arrays_on.hpp"
#include "policies/hooked.hpp"
#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::update_test {

namespace {

constexpr int channels = 5, degree = 2;
constexpr std::size_t count = 1000;

/// A scene with chunks or without.
Scene scene_with(bool chunks) {
  Scene scene = chunks ? with_degree(order_spatially(make_builtin_scene(count)), degree)
                       : random_scene(count, degree, 3);
  return with_features(std::move(scene), channels);
}

/// Other Gaussians, of the same degree and features, elsewhere.
Scene other_scene(std::size_t size = count) {
  return with_features(random_scene(size, degree, 8), channels, 2);
}

/// An uploaded scene has exactly the numbers of `scene`, and bounds of chunks that are those of its
/// Gaussians.
template <class B>
void check_numbers(const B& backend, const SceneView& found, const Scene& scene) {
  CHECK(found.sh_degree == scene.sh_degree);
  for_each_array(
      [&](const char* name, std::size_t each, const auto& array, const auto& values) {
        CAPTURE(name);
        CHECK(same_bits(to_host(backend, array, each), values));
      },
      found, scene);

  const std::vector<ChunkBounds> chunks = to_host(backend, found.chunks);
  const SceneView host = view(scene);
  for (std::size_t c = 0; c < chunks.size(); ++c) {
    CAPTURE(c);
    const ChunkBounds expected = swiftgs::detail::bounds_of_chunk(host, c);
    CHECK(chunks[c].low == expected.low);
    CHECK(chunks[c].high == expected.high);
    CHECK(chunks[c].opacity == expected.opacity);
    if (on_host<B>)
      CHECK(chunks[c].size == expected.size);
    else  // sums of squares may be fused
      CHECK(double(chunks[c].size) == doctest::Approx(double(expected.size)).epsilon(1e-6));
  }
}

Camera camera_of_all() { return turned_camera(120, 80, 0.1, 0.2); }

/// Shows a part of the scene, so that chunks are skipped.
Camera camera_of_few() { return forward_camera(90, 60, 400); }

/// Checks that frames of both cameras show no difference.
template <class B>
void check_frames(BoundRenderer<B>& renderer, const SceneView& found, const SceneView& expected) {
  for (const Camera& camera : {camera_of_all(), camera_of_few()})
    CHECK(same_planes(renderer.render(found, camera, settings_of_all(channels)),
                      renderer.render(expected, camera, settings_of_all(channels))));
}

}  // namespace

SWIFTGS_CONTRACT("update: any range has the bits of a fresh upload") {
  Usual<B> renderer(test::make_backend<B>());
  const Scene other = other_scene();
  for (const bool chunks : {false, true}) {
    CAPTURE(chunks);
    Scene expected = scene_with(chunks);
    auto scene = backend.upload(expected);
    REQUIRE(scene.view().chunks.empty() != chunks);
    // Later ones begin with what earlier ones left.
    for (const std::size_t first : {0, 1, 127, 128, 300, 999, 1000})
      for (const std::size_t size : {0, 1, 2, 127, 128, 129, 400, 1000}) {
        if (first + size > count) continue;
        CAPTURE(first);
        CAPTURE(size);
        const Scene part = subset(other, select(other, [&](std::size_t i) {
                                    return i >= (7 * first) % (count - size + 1) &&
                                           i < (7 * first) % (count - size + 1) + size;
                                  }));
        REQUIRE(part.size() == size);
        const ArraysOn<B> arrays(backend, part);
        backend.update(scene, first, arrays.all);
        replace(expected, first, part);
        check_numbers(backend, scene.view(), expected);
        CHECK(scene.view().chunks.empty() != chunks);
        if (size != 129 && size != 1000) continue;
        const auto fresh = backend.upload(expected);
        check_frames(renderer, scene.view(), fresh.view());
      }
  }
}

SWIFTGS_CONTRACT("update: arrays that are null stay") {
  Usual<B> renderer(test::make_backend<B>());
  const std::size_t first = 200;
  const Scene part = other_scene(301);
  const ArraysOn<B> arrays(backend, part);
  for (const bool chunks : {false, true}) {
    const Scene before = scene_with(chunks);
    for (unsigned which : {1u, 2u, 4u, 8u, 16u, 32u, 64u, means_and_rotations, 0u}) {
      CAPTURE(which);
      auto scene = backend.upload(before);
      SceneArrays some = some_of(arrays.all, which);
      if (which == means_alone || which == means_and_rotations) some.sh_degree = 0, some.feature_channels = 0;
      backend.update(scene, first, some);
      Scene expected = before;
      replace(expected, first, part, which);
      check_numbers(backend, scene.view(), expected);
      const auto fresh = backend.upload(expected);
      check_frames(renderer, scene.view(), fresh.view());
      const RenderSettings settings = settings_of_all(channels);
      CHECK(same_planes(renderer.render(scene, camera_of_all(), settings),
                        renderer.render(backend.upload(before), camera_of_all(), settings)) == (which == 0));
    }
  }
}

SWIFTGS_CONTRACT("update: numbers of training and rows of any stride become those of an upload") {
  // Rows of a part of a table, as training has them.
  constexpr std::size_t row = 3 + 3 + 4 + 1 + 3 + 24 + channels + 2, rest = 14;
  std::vector<float> table(row * count);
  Random random(5);
  for (float& value : table) value = random.f(-1.5, 1.5);
  const auto rows = to_backend(backend, table);
  const auto arrays_of = [&](const float* at, std::size_t size) {
    const auto column = [&](std::size_t i) {
      return FloatArray{at + i, std::ptrdiff_t(row * sizeof(float))};
    };
    return SceneArrays{.count = size,
                       .means = column(0),
                       .scales = column(3),
                       .rotations = column(6),
                       .opacities = column(10),
                       .sh0 = column(11),
                       .sh_rest = column(rest),
                       .sh_degree = degree,
                       .features = column(rest + 24),
                       .feature_channels = channels,
                       .log_scales = true,
                       .logit_opacities = true,
                       .any_rotations = true,
                       .plain_colours = true};
  };
  std::optional<typename B::SceneOn> none;
  const auto fresh = backend.upload(arrays_of(rows.data(), count), none);
  const auto scales = to_host(backend, fresh.view().scales);
  const auto rotations = to_host(backend, fresh.view().rotations);
  const auto opacities = to_host(backend, fresh.view().opacities);
  const auto colours = to_host(backend, fresh.view().sh0);
  double apart = 0;
  const auto note = [&](float found, double wanted) {
    apart = std::max(apart, std::abs(double(found) - wanted));
  };
  for (std::size_t i = 0; i < count; ++i) {
    const float *from = &table[row * i], *q = from + 6;
    for (int c = 0; c < 3; ++c) note(scales[i][c], std::exp(double(from[3 + c])));
    for (int c = 0; c < 3; ++c) note(colours[i][c], (double(from[11 + c]) - 0.5) / 0.28209479177387814);
    const double length = std::hypot(std::hypot(double(q[0]), double(q[1])), std::hypot(q[2], q[3]));
    note(rotations[i].w, q[0] / length), note(rotations[i].x, q[1] / length);
    note(rotations[i].y, q[2] / length), note(rotations[i].z, q[3] / length);
    note(opacities[i], 1 / (1 + std::exp(-double(from[10]))));
  }
  CHECK(apart < 2e-6);

  const std::size_t first = 77, size = 500;
  std::vector<float> changed = table;
  for (std::size_t i = row * first; i < row * (first + size); ++i) changed[i] *= -0.7f;
  const auto of_changed = to_backend(backend, changed);
  auto scene = backend.upload(arrays_of(of_changed.data(), count), none);
  CHECK_FALSE(same_bits(to_host(backend, scene.view().scales), to_host(backend, fresh.view().scales)));
  backend.update(scene, first, arrays_of(rows.data() + row * first, size));
  for_each_array(
      [&](const char* name, std::size_t each, const auto& found, const auto& expected) {
        CAPTURE(name);
        CHECK(same_bits(to_host(backend, found, each), to_host(backend, expected, each)));
      },
      scene.view(), fresh.view());
}

SWIFTGS_CONTRACT("update: copies are one scene and the caller's own stays as it is") {
  const Scene before = scene_with(true), part = other_scene(300);
  const ArraysOn<B> arrays(backend, part);
  Scene expected = before;
  replace(expected, 400, part);
  const auto shared = std::make_shared<const Scene>(before);
  auto scene = backend.upload(shared);
  const auto other_upload = backend.upload(shared);
  auto copy = scene;
  const std::uint64_t identity = scene.view().identity;
  backend.update(copy, 400, arrays.all);
  check_numbers(backend, scene.view(), expected);
  check_numbers(backend, copy.view(), expected);
  check_numbers(backend, other_upload.view(), before);
  CHECK(same_bits(shared->means, before.means));
  CHECK(scene.view().identity == identity);

  // From now on arrays stay where they are, as they do where no caller has the scene.
  auto own = backend.upload(before);
  const SceneView first_view = scene.view(), own_view = own.view();
  replace(expected, 0, part);
  backend.update(scene, 0, arrays.all);
  check_numbers(backend, first_view, expected);
  backend.update(own, 400, arrays.all), backend.update(own, 0, arrays.all);
  check_numbers(backend, own_view, expected);
}

SWIFTGS_CONTRACT("update: recorded frames show it and no memory is taken") {
  Hooked<B> memory;
  Usual<B> renderer(memory.backend(2)), other(test::make_backend<B>());
  const B& on = renderer.backend();
  const Scene part = other_scene(300);
  const ArraysOn<B> arrays(on, part);
  const RenderSettings settings = settings_of_all(channels);
  const Camera camera = camera_of_all();
  for (const bool alone : {true, false}) {
    CAPTURE(alone);
    Scene expected = scene_with(true);
    auto scene = on.upload(expected);
    const auto still = on.upload(other_scene(500));
    const auto placed = [&](const SceneView& view) {
      return alone ? std::vector<PlacedScene>{{view}}
                   : std::vector<PlacedScene>{{still.view()}, {view, {.translation = dvec3(0.2, 0.1, 0.3)}}};
    };
    PlanesOn<B> planes(on, camera.width, camera.height, all_planes(channels), 0);
    const View view = make_view(camera, {}, planes.view());
    Report<B> report;
    renderer.reserve(placed(scene.view()), {&view, 1}, {4000, 100'000});
    const SceneView before = scene.view();
    const auto record = [&] {
      if (alone)
        renderer.record(before, report.data());
      else
        renderer.record(report.data());
      CHECK(report.get(on).overflowed == 0);
      return planes.on_host(on);
    };
    Frame last = record();
    const std::size_t calls = memory.calls();
    for (const std::size_t first : {0, 650, 321}) {
      on.update(scene, first, arrays.all);
      replace(expected, first, part);
      const Frame found = record();
      CHECK_FALSE(same_planes(found, last));
      CHECK(same_planes(found,
                        other.render(placed(other.backend().upload(expected).view()), camera, settings)));
      last = found;
    }
    CHECK(memory.calls() == calls);
  }
}

SWIFTGS_CONTRACT("update: numbers that are not finite are refused on hosts and not drawn on devices") {
  Usual<B> renderer(test::make_backend<B>());
  const float values[] = {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                          std::nanf("")};
  const Scene before = scene_with(true);
  auto scene = backend.upload(before);
  for (const float value : values)
    for (unsigned array = 0; array < 7; ++array) {
      CAPTURE(value);
      CAPTURE(array);
      // Gaussian 6 of the part, in the middle of a chunk that others keep visible.
      Scene part = other_scene(20);
      unsigned number = 0;
      for_each_array(
          [&](const char*, std::size_t each, auto& of) {
            if (number++ == array) reinterpret_cast<float*>(of.data() + 6 * each)[0] = value;
          },
          part);
      const ArraysOn<B> arrays(backend, part);
      if (on_host<B>) {
        const char* const names[] = {"means", "scales",  "rotations", "opacities",
                                     "sh0",   "sh_rest", "features"};
        const std::string message = "scene: " + std::string(names[array]) + " of Gaussian 506 is ";
        CHECK_THROWS_WITH_AS(backend.update(scene, 500, arrays.all), doctest::Contains(message.c_str()),
                             std::invalid_argument);
        CHECK_THROWS_AS(backend.update(scene, 500, some_of(arrays.all, 1u << array)), std::invalid_argument);
        check_numbers(backend, scene.view(), before);
        CHECK_NOTHROW(backend.update(scene, 500, some_of(arrays.all, 0)));
        continue;
      }
      auto changed = backend.upload(before);
      backend.update(changed, 500, arrays.all);
      SceneView without_chunks = changed.view();
      without_chunks.chunks = {};
      check_frames(renderer, changed.view(), without_chunks);
      // What is not finite leaves with the next update.
      const ArraysOn<B> good(backend, before);
      backend.update(changed, 0, good.all);
      check_numbers(backend, changed.view(), before);
    }
}

SWIFTGS_CONTRACT("update: what does not fit the scene is refused") {
  const Scene before = scene_with(true);
  auto scene = backend.upload(before);
  const ArraysOn<B> arrays(backend, other_scene());
  const auto refused = [&](std::size_t first, const SceneArrays& with, const char* why) {
    CHECK_THROWS_WITH_AS(backend.update(scene, first, with), doctest::Contains(why), std::invalid_argument);
  };
  refused(1, arrays.all, "update: 1000 Gaussians from number 1 on, expected some of the scene's 1000");
  SceneArrays some = arrays.all;
  some.count = 3;
  refused(998, some, "update: 3 Gaussians from number 998 on, ");
  refused(std::numeric_limits<std::size_t>::max(), some, " from number 18446744073709551615 on, ");
  some.sh_degree = 1;
  refused(0, some, "update: sh_degree is 1, expected 2 as in the scene");
  some.sh_degree = 4;
  refused(0, some, "scene: sh_degree is 4, expected 0 to 3");
  some.sh_degree = degree, some.feature_channels = 4;
  refused(0, some, "update: feature_channels is 4, expected 5 as in the scene");
  some.feature_channels = channels, some.means.stride = 8;
  refused(0, some, "scene: means: stride is 8 bytes, expected 0 or a multiple of 4 from 12 to ");
  some.means = {reinterpret_cast<const float*>(reinterpret_cast<const char*>(arrays.all.means.data) + 1)};
  refused(0, some, "scene: means: expected an address that is a multiple of 4");
  check_numbers(backend, scene.view(), before);
  some = {};
  CHECK_NOTHROW(backend.update(scene, count, some));
  auto empty = backend.upload(Scene());
  CHECK_NOTHROW(backend.update(empty, 0, some));
}

SWIFTGS_CASE_ON("upload: hosts take memory of arrays again unless somebody else has it", SWIFTGS_TEST_HOSTS) {
  constexpr std::size_t many = 20'000;
  std::vector<float> floats(4 * many, 0.5f);
  const FloatArray all{floats.data()};  // which all read
  const SceneArrays arrays{
      .count = many, .means = all, .scales = all, .rotations = all, .opacities = all, .sh0 = all};
  std::optional<HostScene> scene;
  scene.emplace(backend.upload(arrays, scene));
  const vec3* const first = scene->view().means.data;
  const std::uint64_t identity = scene->view().identity;
  scene.emplace(backend.upload(arrays, scene));
  CHECK(scene->view().means.data == first);
  CHECK(scene->view().identity != identity);
  {
    const HostScene shared = *scene;
    scene.emplace(backend.upload(arrays, scene));
    CHECK(scene->view().means.data != first);
    CHECK(shared.view().means[many - 1] == vec3(0.5f));
  }

  // A number of any block is found, and the scene stays.
  for (const std::size_t at : {std::size_t(0), std::size_t(1) << 14, 3 * many - 1}) {
    const std::string message = "means of Gaussian " + std::to_string(at / 3) + " is inf, expected";
    CAPTURE(message);
    const float kept = std::exchange(floats[at], std::numeric_limits<float>::infinity());
    const vec3* const before = scene->view().means.data;
    CHECK_THROWS_WITH_AS(scene.emplace(backend.upload(arrays, scene)), doctest::Contains(message.c_str()),
                         std::invalid_argument);
    CHECK(scene->view().means.data == before);
    CHECK(scene->view().means[at / 3] == vec3(0.5f));
    floats[at] = kept;
  }
}

SWIFTGS_CONTRACT("update: renderers by name update the scene that they are told and all that share it") {
  const std::string name = std::string(B::name) + "/early/per-pixel/ellipse";
  const auto first = make_renderer(name), second = make_renderer(name), fresh = make_renderer(name);
  const auto shared = std::make_shared<const Scene>(scene_with(true));
  Scene still = *shared, moved = other_scene(600);
  const Scene part = other_scene(300);
  const ArraysOn<B> arrays(backend, part);
  CHECK_THROWS_WITH_AS(first->update_scene(0, 0, arrays.all), doctest::Contains("number 0, expected less"),
                       std::invalid_argument);
  first->set_scene(shared);
  REQUIRE(first->add_scene(std::make_shared<const Scene>(moved)) == 1);
  REQUIRE(second->share_scene(*first));
  const auto drawn_by = [](AnyRenderer& renderer) {
    Frame frame;
    renderer.render(camera_of_all(), settings_of_all(channels), frame);
    return frame;
  };
  const auto update = [&](AnyRenderer& by, std::size_t scene, std::size_t at, unsigned which) {
    by.update_scene(scene, at, some_of(arrays.all, which));
    by.wait();
    replace(scene == 0 ? still : moved, at, part, which);
    fresh->set_scene(std::make_shared<const Scene>(still));
    fresh->add_scene(std::make_shared<const Scene>(moved));
    const Frame expected = drawn_by(*fresh);
    CHECK(same_planes(drawn_by(*first), expected));
    CHECK(same_planes(drawn_by(*second), expected));
  };
  update(*first, 1, 50, means_and_rotations);
  update(*first, 0, 700, every_array);
  update(*second, 1, 300, every_array);
  CHECK(same_bits(shared->means, scene_with(true).means));
  CHECK_THROWS_WITH_AS(first->update_scene(2, 0, arrays.all),
                       "update_scene: the scene is number 2, expected less than 2", std::invalid_argument);
  CHECK_THROWS_AS(first->update_scene(1, 301, arrays.all), std::invalid_argument);
}

SWIFTGS_CASE_ON("update: hosts draw bands that were zero before", SWIFTGS_TEST_HOSTS) {
  Scene before = random_scene(count, 3, 4);
  std::fill(before.sh_rest.begin(), before.sh_rest.end(), 0.0f);
  auto scene = backend.upload(before);
  CHECK(scene.view().sh_degree == 0);
  const Scene part = random_scene(10, 3, 9);
  const ArraysOn<B> arrays(backend, part);
  backend.update(scene, 990, arrays.all);
  Scene expected = before;
  replace(expected, 990, part);
  check_numbers(backend, scene.view(), expected);
}

}  // namespace swiftgs::test::update_test
