// SPDX-License-Identifier: Apache-2.0

// All planes of frames over ranks have the bits of one process.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/serial.hpp>

#include "mpi/away.hpp"
#include "mpi/compare.hpp"
#include "mpi/limited_memory.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

using One = Renderer<Serial, EarlySort, PerPixel, Ellipse>;
using Distributed = DistributedRenderer<Serial, EarlySort, PerPixel, Ellipse>;

/// A view into `frame`, which draws over what it holds, behind `occluder` if there is one.
struct ViewInto {
  Frame frame{};
  View view{};

  ViewInto(const Camera& camera, const Outputs& outputs, const std::vector<float>* occluder,
           const Conventions& conventions = {}) {
    FrameView prepared = prepare(frame, camera.width, camera.height, outputs);
    if (occluder) {
      prepared.occluder = {occluder->data(), std::ptrdiff_t(sizeof(float)) * std::ptrdiff_t(camera.width)};
      prepared.over = true;
    }
    view = make_view(camera, conventions, prepared, vec3(0.1f, 0.2f, 0.3f));
  }
};

}  // namespace

TEST_CASE("mpi planes: they go by way of other memory and by a link") {
  const Scene scene = with_features(make_builtin_scene(2'000)), own = part_of(scene, own_part());
  for (const bool direct : {false, true}) {
    ranks_here().set_direct(direct);
    compare<Away, EarlySort, PerPixel, Ellipse, Serial>(scene, own, some_cameras(), 2, every_plane());
  }
  ranks_here().set_direct(false);
}

TEST_CASE("mpi planes: placed scenes of which each rank holds parts have the bits of one process") {
  const Scene room = with_features(make_builtin_scene(3'000)), thing = with_features(make_builtin_scene(700));
  One one;
  Distributed distributed(ranks_here());
  const Similarity beside{matrix_of(unit(DQuaternion{0.9, 0.1, 0.3, -0.2})), 0.4, dvec3(0.5, -0.3, 1)};
  std::vector<HostScene> uploaded;
  const auto parts_of_rank = [&](std::size_t rank) {
    const ScenePart part{rank, std::size_t(ranks_here().size())};
    uploaded.push_back(one.backend().upload(part_of(room, part)));
    uploaded.push_back(one.backend().upload(part_of(thing, part)));
    const SceneView of_room = uploaded[uploaded.size() - 2].view(), of_thing = uploaded.back().view();
    return std::vector<PlacedScene>{
        {of_room}, {of_thing, beside}, {of_thing, {.scale = 0.2}, 0.7f, {}, {vec3(1, 0, 0.5f), 0.4f}}};
  };
  std::vector<PlacedScene> all;  // numbered rank by rank
  for (std::size_t rank = 0; rank < std::size_t(ranks_here().size()); ++rank)
    for (const PlacedScene& placed : parts_of_rank(rank)) all.push_back(placed);
  const std::vector<PlacedScene> own = parts_of_rank(std::size_t(ranks_here().rank()));
  const std::vector<Camera> cameras = some_cameras();
  const RenderSettings settings = every_plane();
  std::vector<Frame> expected(cameras.size()), found(cameras.size());
  one.render(all, {cameras.data(), cameras.size()}, settings, {expected.data(), expected.size()});
  for (int frame = 0; frame < 3; ++frame) {
    distributed.render(own, {cameras.data(), cameras.size()}, settings, {found.data(), found.size()});
    if (ranks_here().rank() != 0) continue;
    for (std::size_t i = 0; i < cameras.size(); ++i) CHECK(same_planes(found[i], expected[i]));
  }
}

TEST_CASE("mpi planes: views may ask for different planes and lie behind surfaces and over images") {
  const Scene scene = with_features(make_builtin_scene(4'000));
  One one;
  Distributed distributed(ranks_here());
  const auto whole = one.backend().upload(scene);
  const auto part = distributed.backend().upload(part_of(scene, own_part()));
  const Camera camera = builtin_camera(100, 75);
  std::vector<float> occluder(100 * 75);
  for (std::size_t i = 0; i < occluder.size(); ++i) occluder[i] = i % 3 ? 4.0f : INFINITY;

  struct Asked {
    Outputs outputs;
    bool occluded, along_ray = false;
  };
  const Outputs all = every_plane().outputs;
  const std::vector<std::vector<Asked>> frames{
      {{all, true}, {{}, false}, {{.features = 2}, false}, {{.median_depth = true, .normal = true}, true}},
      {{{}, true}, {{}, false}},                              // nothing but colours
      {{{.id = true}, true}, {{.median_id = true}, false}},   // no attributes
      {{{.normal = true}, false}, {{.features = 5}, false}},  // one row and two
      {{{.squared_depth = true}, false}, {all, false}},
      {{all, true, true}, {all, true}, {{}, true, true}, {{.first_depth = true}, false, true}}};
  for (const std::vector<Asked>& asked : frames) {
    std::vector<ViewInto> expected, found;
    std::vector<View> by_one, by_all;
    for (const auto& [outputs, occluded, along_ray] : asked) {
      Conventions conventions;
      if (along_ray) conventions.depth_at = Conventions::DepthAt::ray;
      expected.emplace_back(camera, outputs, occluded ? &occluder : nullptr, conventions);
      found.emplace_back(camera, outputs, occluded ? &occluder : nullptr, conventions);
      by_one.push_back(expected.back().view), by_all.push_back(found.back().view);
    }
    one.render_into(whole.view(), {by_one.data(), by_one.size()});
    distributed.render_into(part.view(), {by_all.data(), by_all.size()});
    std::uint64_t rows = 0;
    for (const DrawnStrip& each : distributed.drawn()) {
      const std::size_t view = each.view_strip.view;
      CHECK(same_rows(found[view].frame, expected[view].frame, each.view_strip));
      rows += std::uint64_t(each.view_strip.rows);
    }
    ranks_here().add_up({&rows, 1});
    CHECK(rows == 75 * asked.size());
  }
}

TEST_CASE("mpi planes: of equal weights the nearest Gaussian has the pixel whatever its rank") {
  // One Gaussian a rank. The last and, behind it, the first have equal weights.
  Scene scene;
  const auto ranks = std::size_t(ranks_here().size()), count = std::max<std::size_t>(ranks, 2);
  for (std::size_t i = 0; i < count; ++i) {
    const bool first = i == 0, last = i + 1 == count;
    scene.means.push_back(vec3(0, 0, last ? 4.0f : first ? 5.0f : 6.0f));
    scene.scales.push_back(vec3(1e5f));
    scene.rotations.push_back({});
    scene.opacities.push_back(last ? 0.25f : first ? 1.0f / 3 : 0.1f);
    scene.sh0.push_back(vec3(1));
  }
  const Camera camera = look_at(dvec3(0), dvec3(0, 0, 1), dvec3(0, -1, 0), 0.8, 40, 70);
  RenderSettings settings;
  settings.outputs.id = settings.outputs.median_id = true;
  Distributed distributed(ranks_here());
  const auto part = distributed.backend().upload(part_of(scene, own_part()));
  Frame frame;
  distributed.render(part.view(), camera, settings, frame);
  if (ranks_here().rank() != 0) return;
  // Two splats leave a transmittance of exactly 1/2; only those behind them leave less.
  const std::uint32_t median = ranks > 2 ? 1 : no_gaussian;
  CHECK(frame.id == std::vector<std::uint32_t>(frame.pixels(), std::uint32_t(count - 1)));
  CHECK(frame.median_id == std::vector<std::uint32_t>(frame.pixels(), median));
}

TEST_CASE("mpi planes: a part with too few features is told to all and they can go on") {
  const int failing = ranks_here().size() - 1;
  const Scene scene = with_features(make_builtin_scene(1'000));
  Scene own = part_of(scene, own_part());
  if (ranks_here().rank() == failing) own.features.resize(3 * own.size()), own.feature_channels = 3;
  One one;
  Distributed distributed(ranks_here());
  const auto part = distributed.backend().upload(own);
  Frame expected, found;
  const Camera camera = builtin_camera(100, 80);
  RenderSettings settings = every_plane();
  const std::string message =
      message_of(failing, [&] { distributed.render(part.view(), camera, settings, found); });
  CHECK(message.ends_with(
      "render: the frame asks for 14 features a Gaussian, expected at most the 3 of the scene"));
  settings.outputs.features = 0;
  one.render(one.backend().upload(scene), camera, settings, expected);
  distributed.render(part.view(), camera, settings, found);
  if (ranks_here().rank() == 0) CHECK(same_planes(found, expected));
}

TEST_CASE("mpi planes: a rank that fails for any attributes is told to all and they can go on") {
  const int failing = ranks_here().size() - 1;
  const Scene scene = with_features(make_builtin_scene(1'000));
  const Camera camera = builtin_camera(100, 80);
  One one;
  Frame expected, found;
  one.render(one.backend().upload(scene), camera, every_plane(), expected);
  for (const bool direct : {false, true}) {
    ranks_here().set_direct(direct);
    DistributedRenderer<Away, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
    const auto part = distributed.backend().upload(part_of(scene, own_part()));
    for (const int attribute : {0, 16}) {
      if (ranks_here().rank() == failing) distributed.backend().failing_attribute = attribute;
      const std::string message =
          message_of(failing, [&] { distributed.render(part.view(), camera, every_plane(), found); });
      CHECK(message.ends_with("thrown by a test"));
      CHECK(distributed.drawn().size == 0);
      distributed.backend().failing_attribute = -1;
      distributed.render(part.view(), camera, every_plane(), found);
      if (ranks_here().rank() == 0) CHECK(same_planes(found, expected));
    }
  }
  ranks_here().set_direct(false);
}

TEST_CASE("mpi planes: where one rank has no memory all throw and can go on") {
  RenderSettings settings = every_plane();
  settings.outputs.features = 0;
  fail_at_each_allocation<Serial>(
      hook_of<CacheLineMemory>(), [](const MemoryHook& memory) { return Serial(memory); }, settings);
}

TEST_CASE("mpi planes: only frames that ask for Gaussians or attributes send them") {
  const Scene scene = with_features(make_builtin_scene(3'000));
  const Camera camera = builtin_camera(190, 130);
  // Of a first frame, whose strips do not go by the clock.
  const auto bytes_of_frame = [&](const Outputs& outputs, std::uint64_t& splats) {
    Distributed distributed(ranks_here());
    const auto part = distributed.backend().upload(part_of(scene, own_part()));
    RenderSettings settings;
    settings.outputs = outputs;
    distributed.render_strips(part.view(), {&camera, 1}, settings);
    splats = 0;
    for (const RankCounters& rank : distributed.counters().ranks) splats += rank.sent;
    return distributed.counters().sent_bytes();
  };
  std::uint64_t splats = 0;
  const auto ranks = std::uint64_t(ranks_here().size());
  const std::uint64_t colour = bytes_of_frame({}, splats);
  CHECK(colour == 52 * splats + 24 * ranks * (ranks - 1));
  CHECK((splats > 0) == (ranks > 1));
  CHECK(bytes_of_frame({.alpha = true, .depth = true}, splats) == colour);
  CHECK(bytes_of_frame({.first_depth = true, .median_depth = true}, splats) == colour);
  CHECK(bytes_of_frame({.id = true}, splats) == colour + 4 * splats);
  CHECK(bytes_of_frame({.normal = true, .median_id = true}, splats) == colour + (4 + 16) * splats);
  CHECK(bytes_of_frame({.features = 5}, splats) == colour + 2 * 16 * splats);
  CHECK(bytes_of_frame(every_plane().outputs, splats) == colour + (4 + 5 * 16) * splats);
}
