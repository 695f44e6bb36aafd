// SPDX-License-Identifier: Apache-2.0

// Frames of several placed scenes, against frames of one scene that holds the same Gaussians.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/project/chunks.hpp>

#include "policies/hooked.hpp"
#include "policies/placed_list.hpp"
#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"

namespace swiftgs::test::placed_scenes_test {

namespace {

constexpr int channels = 5;
constexpr float largest = std::numeric_limits<float>::max();

Scene scene_of_all(std::size_t count, std::uint64_t seed) {
  return with_features(random_scene(count, 3, seed), channels);
}

/// A scene in pieces that begin at no chunk, with tints of amount 0.
std::vector<PlacedScene> pieces(const SceneView& scene, std::size_t each) {
  std::vector<PlacedScene> out;
  for (std::size_t first = 0; first < scene.size(); first += each)
    out.push_back({.scene = range_of(scene, first, std::min(each, scene.size() - first)),
                   .tint = {vec3(3, 0, largest), first == 0 ? -0.0f : 0}});
  return out;
}

SceneView without_gaussians() {
  SceneView scene;
  scene.feature_channels = channels;
  return scene;
}

/// What makes a placed scene invalid, and what a host expects instead.
struct Defect {
  const char* refusal;
  void (*make)(PlacedScene&);
};
constexpr float nan_f = std::numeric_limits<float>::quiet_NaN();
constexpr double nan_d = std::numeric_limits<double>::quiet_NaN();
constexpr Defect defects[] = {
    {"rotation with orthonormal columns", [](PlacedScene& p) { p.world_from_scene.rotation[1][2] = nan_d; }},
    {"rotation with orthonormal columns", [](PlacedScene& p) { p.world_from_scene.rotation = dmat3(0.0); }},
    {"rotation with orthonormal columns", [](PlacedScene& p) { p.world_from_scene.rotation[0] *= 1 + 2e-6; }},
    {"rotation with orthonormal columns",
     [](PlacedScene& p) { p.world_from_scene.rotation[2][0] = INFINITY; }},
    {"rotation, not a mirror", [](PlacedScene& p) { p.world_from_scene.rotation[0] *= -1; }},
    {"finite scale above 0", [](PlacedScene& p) { p.world_from_scene.scale = 0; }},
    {"finite scale above 0", [](PlacedScene& p) { p.world_from_scene.scale = -1; }},
    {"finite scale above 0", [](PlacedScene& p) { p.world_from_scene.scale = nan_d; }},
    {"finite scale above 0", [](PlacedScene& p) { p.world_from_scene.scale = INFINITY; }},
    {"finite translation", [](PlacedScene& p) { p.world_from_scene.translation.y = -INFINITY; }},
    {"finite translation", [](PlacedScene& p) { p.world_from_scene.translation.z = nan_d; }},
    {"opacity of 0 to 1", [](PlacedScene& p) { p.opacity = nan_f; }},
    {"opacity of 0 to 1", [](PlacedScene& p) { p.opacity = -0.1f; }},
    {"opacity of 0 to 1", [](PlacedScene& p) { p.opacity = 1.1f; }},
    {"clip of 0 to 6 half-spaces", [](PlacedScene& p) { p.clip.half_space_count = 1 << 20; }},
    {"clip of 0 to 6 half-spaces", [](PlacedScene& p) { p.clip.half_space_count = 7; }},
    {"clip of 0 to 6 half-spaces", [](PlacedScene& p) { p.clip.half_space_count = -1; }},
    {"clip with half-spaces of finite numbers",
     [](PlacedScene& p) { p.clip.half_space_count = 1, p.clip.half_spaces[0].w = nan_f; }},
    {"clip with half-spaces of finite numbers",
     [](PlacedScene& p) { p.clip.half_space_count = 6, p.clip.half_spaces[5].x = INFINITY; }},
    {"clip with a finite centre", [](PlacedScene& p) { p.clip.centre.y = nan_f; }},
    {"clip with a finite centre", [](PlacedScene& p) { p.clip.centre.y = INFINITY, p.clip.radius = 1; }},
    {"clip with a radius of 0 or more", [](PlacedScene& p) { p.clip.radius = nan_f; }},
    {"clip with a radius of 0 or more", [](PlacedScene& p) { p.clip.radius = -1; }},
    {"tint with an amount of 0 to 1", [](PlacedScene& p) { p.tint.amount = nan_f; }},
    {"tint with an amount of 0 to 1", [](PlacedScene& p) { p.tint.amount = -0.1f; }},
    {"tint with an amount of 0 to 1", [](PlacedScene& p) { p.tint.amount = 1.1f; }},
    {"tint with a finite colour of 0 or more", [](PlacedScene& p) { p.tint.colour.y = nan_f; }},
    {"tint with a finite colour of 0 or more", [](PlacedScene& p) { p.tint.colour.z = INFINITY; }},
    {"tint with a finite colour of 0 or more", [](PlacedScene& p) { p.tint.colour.x = -0.1f; }}};

}  // namespace

SWIFTGS_CONTRACT("placed scenes: a scene in pieces has the bits of the whole in all planes") {
  Usual<B> renderer(test::make_backend<B>());
  Usual<B, AdaptiveSort> adaptive(test::make_backend<B>());
  for (const int degree : {3, 2, 1, 0}) {
    const bool chunks = degree == 0;
    const Scene scene =
        with_features(chunks ? make_builtin_scene(20'000) : random_scene(20'000, degree, 7), channels);
    const auto uploaded = backend.upload(scene);
    CHECK(uploaded.view().chunks.empty() != chunks);
    const Camera camera = turned_camera(150, 90, 0.2, 0.4);
    const RenderSettings settings = settings_of_all(channels);
    const Frame whole = renderer.render(uploaded, camera, settings);
    const Statistics taken = renderer.statistics();
    REQUIRE(taken.visible > 1000);
    for (const std::size_t each : {20'000, 6'000, 1'024, 300}) {
      CAPTURE(each);
      std::vector<PlacedScene> placed = pieces(uploaded.view(), each);
      CHECK(same_planes(renderer.render(placed, camera, settings), whole));
      CHECK(renderer.statistics().visible == taken.visible);
      CHECK(renderer.statistics().gaussians == scene.size());
      CHECK(same_planes(adaptive.render(placed, camera, settings), whole));
      placed.insert(placed.begin() + 1, {range_of(uploaded.view(), 5, 0)});
      placed.push_back({without_gaussians()});
      CHECK(same_planes(renderer.render(placed, camera, settings), whole));
    }
  }
}

SWIFTGS_CONTRACT("placed scenes: clips and opacities are those of scenes that were cut and made fainter") {
  Usual<B> renderer(test::make_backend<B>());
  const Scene scene = scene_of_all(1500, 4);
  const auto uploaded = backend.upload(scene);
  const Camera camera = turned_camera(150, 90, 0.1);
  RenderSettings settings = settings_of_all(channels);
  const auto draw = [&](const PlacedScene& placed) {
    return renderer.render(std::vector<PlacedScene>{placed}, camera, settings);
  };
  Clip both = Clip::sphere(vec3(0, 0, 5), 4);
  both.half_space_count = 1, both.half_spaces[0] = vec4(1, 0.3f, 0, 0.2f);
  for (const Clip& clip : {Clip::box(vec3(-1, -2, 1), vec3(2, 1, 8)), Clip::sphere(vec3(0.5f, 0, 6), 3), both,
                           Clip::sphere(vec3(0), 0)}) {
    const Scene cut = subset(scene, select(scene, [&](std::size_t i) { return clip.shows(scene.means[i]); }));
    CHECK(cut.size() < 1200);
    CHECK(same_but_ids(draw({uploaded.view(), {}, 1, clip}),
                       renderer.render(backend.upload(cut), camera, settings)));
  }
  Scene faint = scene;
  for (float& opacity : faint.opacities) opacity *= 0.3f;
  for (const bool antialiased : {true, false}) {
    settings.conventions.antialiased = antialiased;
    CHECK(same_planes(draw({uploaded.view(), {}, 0.3f}),
                      renderer.render(backend.upload(faint), camera, settings)));
  }
  std::vector<PlacedScene> cleared(1);
  cleared.clear();
  for (const std::vector<PlacedScene>& scenes : {std::vector<PlacedScene>(), cleared}) {
    RenderSettings colour_alone;
    colour_alone.background = vec3(0.5f);
    CHECK(renderer.render(scenes, camera, colour_alone).colour[0] == 0.5f);
    CHECK(renderer.statistics().visible == 0);
    CHECK(renderer.visible_by_scene().empty());
  }
  const Clip huge = Clip::box(vec3(-1e38f), vec3(1e38f));
  CHECK(same_planes(draw({uploaded.view(), {}, 1, huge}), renderer.render(uploaded, camera, settings)));
  const Frame none = draw({uploaded.view(), {}, 0});
  CHECK(renderer.statistics().visible == 0);
  CHECK(none.alpha[0] == 0);
}

SWIFTGS_CONTRACT("placed scenes: recorded frames follow them where they go, and take no memory") {
  Hooked<B> memory;
  Usual<B> renderer(memory.backend(2)), other(test::make_backend<B>());
  const auto still = backend.upload(scene_of_all(900, 5)), part = backend.upload(scene_of_all(300, 6));
  const auto at = [&](int i) {
    return std::vector<PlacedScene>{{still.view()},
                                    {part.view(), moved(1, dvec3(0.1 * i, 0.2, 0.5)), i % 3 == 2 ? 0.5f : 1},
                                    {part.view(),
                                     moved(0.5),
                                     1,
                                     i % 2 == 1 ? Clip::sphere(vec3(0), 5) : Clip(),
                                     {vec3(1, 0.1f, 0), 0.2f * float(i)}}};
  };
  const Camera camera = turned_camera(90, 70, 0.1);
  PlanesOn<B> on(renderer.backend(), camera.width, camera.height, all_planes(channels), 0);
  const View view = make_view(camera, {}, on.view());
  Report<B> report;
  renderer.reserve(at(0), {&view, 1}, {2000, 40'000});
  renderer.record(report.data());
  renderer.pick(0, 0);  // takes its own memory
  const std::size_t calls = memory.calls();
  for (int i = 0; i < 6; ++i) {
    if (i != 0) renderer.set_scenes(at(i));
    renderer.record(report.data());
    CHECK(report.get(renderer.backend()).overflowed == 0);
    const Frame wanted = other.render(at(i), camera, settings_of_all(channels));
    CHECK(same_planes(on.on_host(renderer.backend()), wanted));
    CHECK(renderer.pick(45, 35).gaussian == other.pick(45, 35).gaussian);
  }
  CHECK(memory.calls() == calls);
  // Through the pose of a scene that stands by itself, and on.
  std::vector<PlacedScene> one{{part.view(), moved(0.9)}};
  renderer.reserve(one, {&view, 1}, {2000, 40'000});
  for (const Similarity& pose : {Similarity(), moved(0.7)}) {
    one[0].world_from_scene = pose;
    renderer.set_scenes(one);
    renderer.record(report.data());
    CHECK(report.get(renderer.backend()).overflowed == 0);
    CHECK(same_planes(on.on_host(renderer.backend()), other.render(one, camera, settings_of_all(channels))));
  }
  const auto bare = backend.upload(random_scene(300, 0, 1));
  CHECK_THROWS_AS(renderer.set_scenes(std::vector<PlacedScene>{{bare.view(), moved(0.9)}}),
                  std::invalid_argument);
  View of_none = view;
  of_none.shows = {0, 0};
  CHECK_THROWS_AS(renderer.set_views({&of_none, 1}), std::invalid_argument);
  renderer.reserve(at(0), {&view, 1}, {2000, 40'000});
  std::vector<PlacedScene> fewer = at(0), larger = at(0);
  fewer.pop_back(), larger[1].scene = still.view();
  CHECK_THROWS_WITH_AS(renderer.set_scenes(fewer), doctest::Contains("is 2, expected 3 as reserved"),
                       std::invalid_argument);
  CHECK_THROWS_WITH_AS(renderer.set_scenes(larger),
                       doctest::Contains("placed scene 1 has 900 Gaussians, expected 300 as reserved"),
                       std::invalid_argument);
}

SWIFTGS_CONTRACT("placed scenes: recorded ones that others write to are drawn where they are valid") {
  Usual<B> renderer(test::make_backend<B>()), other(test::make_backend<B>());
  const auto still = backend.upload(scene_of_all(900, 5)), part = backend.upload(scene_of_all(300, 6));
  const std::vector<PlacedScene> good{{still.view()},
                                      {part.view(), moved(1, dvec3(0.1, 0.2, 0.5)), 0.9f},
                                      {part.view(), moved(0.5), 1, Clip::sphere(vec3(0), 5)}};
  const Camera camera = turned_camera(90, 70, 0.1);
  PlanesOn<B> on(renderer.backend(), camera.width, camera.height, all_planes(channels), 0);
  const View view = make_view(camera, {}, on.view());
  Report<B> report;
  renderer.reserve(good, {&view, 1}, {3000, 60'000});
  const auto write = [&](std::size_t which, const PlacedScene& to) {
    const std::size_t begin = offsetof(PlacedScene, world_from_scene), end = sizeof(PlacedScene);
    const auto* bytes = reinterpret_cast<const unsigned char*>(&to);
    CopyToBackend<RecordedScenesOn<B>>::copy(
        Span<const unsigned char>{bytes + begin, end - begin},
        reinterpret_cast<unsigned char*>(renderer.recorded_scenes().data + which) + begin);
  };
  const auto draws = [&](const std::vector<PlacedScene>& wanted) {
    renderer.record(report.data());
    CHECK(report.get(renderer.backend()).overflowed == 0);
    return same_planes(on.on_host(renderer.backend()),
                       other.render(wanted, camera, settings_of_all(channels)));
  };
  using Numbers = std::vector<std::size_t>;
  CHECK(draws(good));
  for (int i = 0; i < 3; ++i) {
    std::vector<PlacedScene> wanted = good;
    wanted[1].world_from_scene = moved(0.8 + 0.1 * i), wanted[1].opacity = 0.5f;
    wanted[2].clip = Clip::box(vec3(-1), vec3(2, float(i), 9)), wanted[0].world_from_scene = moved(1.1);
    wanted[std::size_t(i)].tint = {vec3(0, 0.3f, 2), 0.5f};
    for (const std::size_t which : {0, 1, 2}) write(which, wanted[which]);
    CHECK(draws(wanted));
    CHECK(renderer.refused_scenes().empty());
  }
  renderer.set_scenes(good);
  CHECK(draws(good));

  for (const Defect& defect : defects)
    for (const std::size_t which : {0, 2}) {
      CAPTURE(defect.refusal);
      CAPTURE(which);
      PlacedScene bad = good[which];
      defect.make(bad);
      CHECK_FALSE(bad.is_valid());
      write(which, bad);
      if constexpr (on_host<RecordedScenesOn<B>>) {
        CHECK_THROWS_WITH_AS(renderer.record(report.data()), doctest::Contains(defect.refusal),
                             std::invalid_argument);
        CHECK(renderer.refused_scenes().empty());
      } else {
        std::vector<PlacedScene> without = good;
        without[which].opacity = 0;
        CHECK(draws(without));
        CHECK(renderer.refused_scenes() == Numbers{which});
      }
      write(which, good[which]);
      CHECK(draws(good));
      CHECK(renderer.refused_scenes().empty());
    }

  // All at once. Views tell of the scenes that they show.
  PlacedScene bad = good[0];
  bad.world_from_scene.rotation = dmat3(0.0);
  for (const std::size_t which : {0, 1, 2}) write(which, bad);
  if constexpr (!on_host<RecordedScenesOn<B>>) {
    std::vector<PlacedScene> none = good;
    for (PlacedScene& placed : none) placed.opacity = 0;
    CHECK(draws(none));
    CHECK(renderer.refused_scenes() == Numbers{0, 1, 2});
    View of_last = view;
    of_last.shows = {1, 2};
    renderer.reserve(good, {&of_last, 1}, {3000, 60'000});
    for (const std::size_t which : {0, 1}) write(which, bad);
    renderer.record(report.data());
    CHECK(renderer.refused_scenes() == Numbers{1});
    renderer.reserve(good, {&view, 1}, {3000, 60'000});
    write(2, bad);
  }
  renderer.set_scenes(good);  // mends them
  CHECK(draws(good));
  CHECK(renderer.refused_scenes().empty());
}

SWIFTGS_CONTRACT("placed scenes: thousands of frames of scenes that come and go and move keep their bits") {
  Usual<B> renderer(test::make_backend<B>());
  std::vector<typename B::SceneOn> uploaded;
  for (std::size_t i = 0; i < 5; ++i)
    uploaded.push_back(backend.upload(random_scene(20 + 30 * i, 1, 20 + i)));
  const Camera camera = forward_camera(40, 30);
  RenderSettings settings;
  settings.outputs.id = true;
  constexpr int cycle = 50, frames = has_shaders<B> ? 1000 : 10'000;
  std::vector<Frame> first;
  std::size_t memory = 0, different = 0;
  Frame frame;
  for (int i = 0; i < frames; ++i) {
    const int k = i % cycle;
    std::vector<PlacedScene> placed;
    for (int scene = 0; scene < 5; ++scene)
      if ((k + scene) % 3 != 0)
        placed.push_back(
            {uploaded[std::size_t((scene + k) % 5)].view(), moved(1, dvec3(0.02 * k, 0.1 * scene, 1))});
    renderer.render(placed, camera, settings, frame);
    if (i < cycle)
      first.push_back(frame), memory = renderer.memory().total();
    else
      different += !same_planes(frame, first[std::size_t(k)]);
  }
  CHECK(different == 0);
  CHECK(renderer.memory().total() == memory);
  CHECK_FALSE(same_planes(first[0], first[1]));
}

SWIFTGS_CONTRACT("placed scenes: a pair of a view and a placed scene takes 64 bytes at most") {
  constexpr std::size_t views = 64, scenes = 100;
  const auto whole = backend.upload(random_scene(scenes * chunk_size, 0, 3));
  const auto memory_of = [&](std::size_t parts) {
    Usual<B> renderer(test::make_backend<B>());
    std::vector<PlacedScene> placed;
    const std::size_t each = scenes * chunk_size / parts;
    for (std::size_t i = 0; i < parts; ++i)
      placed.push_back({range_of(whole.view(), i * each, each), moved(1, dvec3(0, 0, 1e-3))});
    const std::vector<Camera> cameras(views, forward_camera(32, 32));
    std::vector<Frame> frames(views);
    renderer.render(placed, {cameras.data(), views}, {}, {frames.data(), views});
    return renderer.memory().total();
  };
  CHECK(memory_of(scenes) <= memory_of(1) + 64 * views * scenes + scenes * sizeof(PlacedScene));
}

SWIFTGS_CONTRACT("placed scenes: a Gaussian's number tells its scene, and splats are counted by scene") {
  Usual<B> renderer(test::make_backend<B>());
  CHECK_THROWS_AS(renderer.visible_by_scene(), std::logic_error);
  const auto a = backend.upload(random_scene(400, 0, 1)), b = backend.upload(random_scene(300, 0, 2));
  const std::vector<PlacedScene> placed{{a.view()},
                                        {b.view(), moved(0.5)},
                                        {SceneView()},
                                        {b.view(), {.translation = dvec3(0, 0, -1000)}},
                                        {a.view(), {}, 0.5f}};
  const std::pair<std::uint32_t, std::pair<std::size_t, std::size_t>> numbers[] = {
      {0, {0, 0}},   {399, {0, 399}}, {400, {1, 0}},   {699, {1, 299}},
      {700, {3, 0}}, {1000, {4, 0}},  {1399, {4, 399}}};
  for (const auto& [number, expected] : numbers) {
    const PlacedIndex index = placed_index(placed, number);
    CHECK(index.scene == expected.first);
    CHECK(index.gaussian == expected.second);
  }
  CHECK_THROWS_WITH_AS(placed_index(placed, 1400),
                       "placed_index: the Gaussian is 1400, expected less than 1400", std::invalid_argument);
  CHECK_THROWS_AS(placed_index(placed, no_gaussian), std::invalid_argument);

  const Camera camera = turned_camera(90, 60, 0.1);
  std::vector<std::size_t> expected;
  for (const PlacedScene& one : placed) {
    renderer.render(std::vector<PlacedScene>{one}, camera);
    expected.push_back(renderer.statistics().visible);
  }
  CHECK(expected[0] > 100);
  CHECK(expected[1] > 30);
  renderer.render(placed, camera);
  CHECK(renderer.visible_by_scene() == expected);
}

TEST_CASE("placed scenes: a range that begins with a chunk has chunks that hold its Gaussians") {
  const Scene scene = order_spatially(make_builtin_scene(20'000));
  const std::vector<ChunkBounds> chunks = chunk_bounds(view(scene));
  SceneView whole = view(scene);
  whole.chunks = {chunks.data(), chunks.size()};
  for (std::size_t first = 0; first <= 4 * chunk_size; first += chunk_size / 4) {
    CAPTURE(first);
    const SceneView range = range_of(whole, first, scene.size() - first);
    CHECK((first % chunk_size != 0 || !range.chunks.empty()));
    std::size_t outside = 0;
    for (std::size_t i = 0; i < range.size() && !range.chunks.empty(); ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const ChunkBounds& chunk = range.chunks[i / chunk_size];
        outside += range.means[i][axis] < chunk.low[axis] || range.means[i][axis] > chunk.high[axis];
      }
    CHECK(outside == 0);
  }
}

TEST_CASE("placed scenes: what cannot be placed is refused") {
  Usual<Serial> renderer;
  const auto uploaded = renderer.backend().upload(random_scene(10, 0, 1));
  const Camera camera = forward_camera(20, 20);
  const auto render = [&](PlacedScene placed) {
    placed.scene = uploaded.view();
    renderer.render(std::vector<PlacedScene>{placed}, camera);
  };
  CHECK_NOTHROW(render({}));
  Clip clip;
  clip.half_space_count = 1, clip.half_spaces[1].w = nan_f;  // the others do not count
  CHECK_NOTHROW(render({.clip = clip}));
  CHECK(PlacedScene{.clip = Clip::sphere(vec3(0), 0)}.is_valid());
  View view = make_view(camera, {}, {.width = 20, .height = 20});
  view.shows = {1, 1};
  CHECK_THROWS_WITH_AS(renderer.render_into(uploaded, Span<const View>{&view, 1}),
                       doctest::Contains("a view shows 1 placed scenes from number 1 on, "),
                       std::invalid_argument);
  CHECK_THROWS_AS(range_of(uploaded.view(), 5, 6), std::invalid_argument);
}

}  // namespace swiftgs::test::placed_scenes_test
