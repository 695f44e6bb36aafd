// SPDX-License-Identifier: Apache-2.0

// Frames over ranks have the bits of one process.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/serial.hpp>

#include "mpi/compare.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// A renderer on one process with a whole scene, and one over ranks with their parts.
struct Pair {
  explicit Pair(const Scene& scene)
      : whole(one.backend().upload(scene)), part(distributed.backend().upload(part_of(scene, own_part()))) {}

  void render(const View& by_one, const View& by_all) {
    one.render_into(whole.view(), Span{&by_one, 1});
    distributed.render_into(part.view(), Span{&by_all, 1});
  }

  Renderer<Cpu, EarlySort, PerPixel, Ellipse> one{};
  DistributedRenderer<Cpu, EarlySort, PerPixel, Ellipse> distributed{ranks_here()};
  Cpu::SceneOn whole, part;
};

}  // namespace

TEST_CASE("mpi frames: each policy draws the bits of one process") {
  const Scene scene = make_builtin_scene(6'000);
  compare_every_policy(scene, part_of(scene, own_part()), some_cameras());
}

namespace {

/// Layers of different colours at one depth; neighbours lie on different ranks.
Scene equal_depths() {
  Scene scene;
  for (std::size_t i = 0; i < 24; ++i) {
    scene.means.push_back(vec3(0.01f * float(i % 3), 0.02f * float(i % 5), 4));
    scene.scales.push_back(vec3(0.5f));
    scene.rotations.push_back({});
    scene.opacities.push_back(0.4f);
    scene.sh0.push_back(vec3(i % 2 ? 1.5f : -1.5f, float(i % 7) - 3, float(i % 5) - 2));
  }
  return scene;
}

/// Gives a splat a colour that no float holds.
void make_colourless(Scene& scene, std::size_t i) {
  scene.sh0[i] = vec3(3e38f), std::fill_n(scene.sh_rest.begin() + std::ptrdiff_t(45 * i), 45, 3e38f);
}

/// Splats as wide as the image, and colourless ones.
Scene wide_and_colourless() {
  Scene scene = make_builtin_scene(500);
  for (std::size_t i = 0; i < scene.size(); i += 25) scene.scales[i] *= 300.0f;
  for (std::size_t i = 3; i < scene.size(); i += 10) make_colourless(scene, i);
  return scene;
}

/// Before all others one that is colourless, the first of the part of `rank`.
Scene colourless_on(std::size_t rank) {
  Scene scene = make_builtin_scene(300);
  for (std::size_t i = 0; i < scene.size(); ++i) scene.means[i].z = 5;
  const std::size_t i = ScenePart{rank, std::size_t(ranks_here().size())}.range(scene.size()).begin;
  scene.means[i] = vec3(0, 0, 4), scene.scales[i] = vec3(3), scene.opacities[i] = 0.9f;
  make_colourless(scene, i);
  return scene;
}

Scene as_trained() {
  Scene scene = make_builtin_scene(2'000);
  scene.model = {
      .blur = 0.1f, .antialiased = true, .order = SplatOrder::distance, .colours = ColourSpace::linear};
  return scene;
}

/// All but the last third lose their harmonics: the ranks' parts have unlike degrees.
Scene unlike_degrees() {
  Scene scene = make_builtin_scene(900);
  std::fill(scene.sh_rest.begin(), scene.sh_rest.begin() + 45 * 600, 0.0f);
  return scene;
}

}  // namespace

TEST_CASE("mpi frames: all planes of every kind of scene and view have the bits of one process") {
  struct Case {
    const char* name;
    Scene scene;
    std::vector<Camera> cameras;
  };
  const Camera ahead = look_at(dvec3(0), dvec3(0, 0, 1), dvec3(0, -1, 0), 0.8, 100, 90);
  Camera fisheye = builtin_camera(96, 96), wide = builtin_camera(120, 80);
  fisheye.lens.model = LensModel::fisheye, fisheye.fx = fisheye.fy = 30;
  wide.fx *= 0.4, wide.fy *= 0.4;
  std::vector<Case> cases{
      {"views of unlike sizes", make_builtin_scene(3'000), some_cameras()},
      {"lenses", make_builtin_scene(3'000), {builtin_panorama(), fisheye, builtin_panorama()}},
      {"a model of its own", as_trained(), {wide}},
      {"equal depths", equal_depths(), {ahead}},
      {"splats that are wide or colourless", wide_and_colourless(), {builtin_camera(200, 150)}},
      {"unlike degrees", unlike_degrees(), {builtin_camera(120, 80)}},
      {"fewer rows of tiles than ranks", unlike_degrees(), {builtin_camera(200, 17)}},
      {"no Gaussians", {}, {builtin_camera(120, 80)}},
  };
  for (int rank = 0; rank < ranks_here().size(); ++rank)
    cases.push_back({"one that is colourless on any rank", colourless_on(std::size_t(rank)), {ahead}});
  for (const Case& each : cases) {
    const std::string name = each.name;
    CAPTURE(name);
    const Scene scene = with_features(each.scene), own = part_of(scene, own_part());
    compare<Cpu, EarlySort, PerPixel, Ellipse>(scene, own, each.cameras, 2, every_plane());
    compare<Serial, StandardSort, AxisSharedThreshold<FloatSplit>, Obb>(scene, own, each.cameras, 1,
                                                                        every_plane());
  }
  // One rank has all.
  const Scene scene = with_features(make_builtin_scene(900)), none = part_of(scene, {0, 65535});
  for (int holder = 0; holder < ranks_here().size(); ++holder)
    compare<Cpu, EarlySort, PerPixel, Ellipse>(scene, ranks_here().rank() == holder ? scene : none,
                                               {builtin_camera(120, 80)}, 2, every_plane());
}

TEST_CASE("mpi frames: messages that are cut bring the same bits") {
  ranks_here().set_longest_message(1000);
  compare<Cpu, EarlySort, PerPixel, Ellipse>(make_builtin_scene(3'000), some_cameras(), 2);
  ranks_here().set_longest_message(std::size_t(1) << 30);
  CHECK_THROWS_AS(ranks_here().set_longest_message((std::size_t(1) << 30) + 1), std::invalid_argument);
}

TEST_CASE("mpi frames: strips are drawn over images and behind surfaces and into other formats") {
  const Camera camera = builtin_camera(200, 150);
  Pair pair(make_builtin_scene(3'000));
  std::vector<float> occluder(200 * 150);
  for (std::size_t i = 0; i < occluder.size(); ++i) occluder[i] = i % 3 ? 4.0f : INFINITY;
  for (const PixelFormat format :
       {PixelFormat::rgba_float, PixelFormat::rgba_half, PixelFormat::rgba_8, PixelFormat::bgra_8}) {
    const std::size_t pixel = bytes_per_pixel(format);
    std::vector<unsigned char> expected(200 * 150 * pixel), found(200 * 150 * pixel);
    const auto view_into = [&](std::vector<unsigned char>& image) {
      std::fill(image.begin(), image.end(), static_cast<unsigned char>(60));
      // Bottom row first in memory.
      FrameView frame{.width = 200, .height = 150};
      frame.colour = {image.data() + 200 * pixel * 149, -std::ptrdiff_t(200 * pixel)};
      frame.format = format, frame.over = true;
      frame.occluder = {occluder.data(), 200 * sizeof(float)};
      return make_view(camera, Conventions::gsplat(), frame);
    };
    pair.render(view_into(expected), view_into(found));
    // Outside of the strip nothing was written.
    std::vector<bool> own_row(150);
    for (const DrawnStrip& each : pair.distributed.drawn())
      for (int row = 0; row < each.view_strip.rows; ++row)
        own_row[std::size_t(each.view_strip.first_row + row)] = true;
    std::size_t wrong = 0;
    for (std::size_t row = 0; row < 150; ++row)
      for (std::size_t k = 0; k < 200 * pixel; ++k) {
        const std::size_t at = (149 - row) * 200 * pixel + k;
        wrong += found[at] != (own_row[row] ? expected[at] : 60);
      }
    CHECK(wrong == 0);
  }
}

TEST_CASE("mpi frames: a rectangle of an image is shared out as well") {
  const Camera camera = builtin_camera(300, 260);
  Pair pair(make_builtin_scene(3'000));
  Frame expected, found;
  const auto view_of = [&](Frame& frame) {
    return make_view(camera, Conventions::gsplat(), prepare(frame, 130, 100, {true, true}), vec3(0),
                     {32, 64});
  };
  pair.render(view_of(expected), view_of(found));
  for (const DrawnStrip& each : pair.distributed.drawn()) CHECK(same_rows(found, expected, each.view_strip));
}

TEST_CASE("mpi frames: counters tell what went between ranks and how even strips are") {
  const Scene scene = make_builtin_scene(20'000);
  DistributedRenderer<Cpu, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
  const auto part = distributed.backend().upload(part_of(scene, own_part()));
  Frame frame;
  for (int k = 0; k < 4; ++k) distributed.render(part.view(), builtin_camera(640, 400), {}, frame);
  const FrameCounters& counters = distributed.counters();
  const auto ranks = std::size_t(ranks_here().size());
  CHECK(counters.ranks.size() == ranks);
  CHECK(counters.imbalance() >= 1);
  std::uint64_t sent = 0, received = 0, gaussians = 0, drawn = 0, rows = 0, splats = 0;
  for (const RankCounters& rank : counters.ranks) {
    sent += rank.traffic.sent_bytes, received += rank.traffic.received_bytes;
    gaussians += rank.gaussians, drawn += rank.drawn, rows += rank.rows, splats += rank.sent;
    CHECK(rank.frame_ns >= rank.project_ns);
    CHECK(rank.bytes > 0);
  }
  CHECK(sent == received);
  CHECK(sent == counters.sent_bytes());
  CHECK(gaussians == scene.size());
  CHECK(10 * drawn > 9 * counters.visible());  // a few lie between pixel centres and touch no tile
  CHECK(drawn <= ranks * counters.visible());
  CHECK(rows == 25);
  if (ranks == 1) CHECK((sent == 0 && splats == 0));
  if (ranks > 1) {
    CHECK(counters.messages() >= ranks * (ranks - 1));
    // A splat has 52 bytes; each rank tells the others besides what comes.
    CHECK(splats > 0);
    CHECK(sent >= 52 * splats);
  }
}

TEST_CASE("mpi frames: steady frames take no more memory") {
  DistributedRenderer<Cpu, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
  const auto part = distributed.backend().upload(make_builtin_scene(4'000, own_part()));
  Frame frame;
  // A row of tiles a rank: strips move by the clock, but none is left without a row, so these stay.
  const Camera camera = builtin_camera(300, 16 * ranks_here().size());
  for (int k = 0; k < 2; ++k) distributed.render(part.view(), camera, {}, frame);
  const std::size_t second = distributed.memory();
  for (int k = 0; k < 6; ++k) distributed.render(part.view(), camera, {}, frame);
  CHECK(distributed.memory() == second);
  CHECK(distributed.counters().ranks[0].rows == 1);
}
