// SPDX-License-Identifier: Apache-2.0

// What one rank finds wrong, all ranks learn.
#include <cstring>
#include <stdexcept>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/cpu.hpp>

#include "mpi/compare.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE("mpi agreement: where one rank fails all throw and can go on") {
  const Scene scene = make_builtin_scene(2'000);
  const Camera camera = builtin_camera(200, 150);
  Renderer<Cpu, EarlySort, PerPixel, Ellipse> one;
  Frame expected, found;
  one.render(one.backend().upload(scene), camera, all_outputs(), expected);

  // The last rank's memory ends at every allocation of a frame in turn, until a frame needs no more.
  struct Limited {
    std::size_t left = 1000000;
    static void* allocate(void* self, std::size_t bytes) {
      std::size_t& left = static_cast<Limited*>(self)->left;
      if (left == 0) throw CapacityError("bytes for this test", bytes, 0);
      --left;
      return CacheLineMemory::allocate(bytes);
    }
    static void release(void*, void* memory, std::size_t) { CacheLineMemory::release(memory); }
  } limited;
  DistributedRenderer<Cpu, EarlySort, PerPixel, Ellipse> distributed(
      ranks_here(), Cpu(1, MemoryHook{Limited::allocate, Limited::release, &limited}));
  const auto part = distributed.backend().upload(part_of(scene, own_part()));
  const int last = ranks_here().size() - 1;
  int failures = 0;
  for (std::size_t allowed = 0; allowed < 100; ++allowed) {
    if (ranks_here().rank() == last) limited.left = allowed % 3;
    std::string message;
    try {
      distributed.render(part.view(), camera, all_outputs(), found);
    } catch (const CapacityError& error) {
      CHECK(ranks_here().rank() == last);
      message = error.what();
    } catch (const RankError& error) {
      CHECK(error.rank() == last);
      message = error.what();
    }
    const bool failed = !message.empty();
    CHECK(ranks_here().all(failed) == !ranks_here().all(!failed));  // all or none
    if (failed) {
      ++failures;
      CHECK(message.find("bytes for this test: ") != std::string::npos);
      continue;
    }
    if (ranks_here().rank() == 0) CHECK(same_bits(found, expected));
    break;
  }
  CHECK(failures > 3);
}

TEST_CASE("mpi agreement: views that differ between ranks are refused on all of them") {
  if (ranks_here().size() == 1) return;
  DistributedRenderer<Cpu, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
  const auto part = distributed.backend().upload(make_builtin_scene(500, own_part()));
  Camera camera = builtin_camera(100, 80);
  Frame frame;
  if (ranks_here().rank() == 1) camera.fx *= 1.0001;
  CHECK_THROWS_WITH_AS(
      distributed.render(part.view(), camera, {}, frame),
      "render: the views of rank 1 differ from those of rank 0, expected the same on all ranks",
      std::invalid_argument);
  distributed.render(part.view(), builtin_camera(100, 80), {}, frame);
  if (ranks_here().rank() == 0) CHECK(frame.width == 100);
  // So are planes that only one rank asks for.
  RenderSettings settings;
  settings.outputs.alpha = ranks_here().rank() == 1;
  CHECK_THROWS_AS(distributed.render(part.view(), builtin_camera(100, 80), settings, frame),
                  std::invalid_argument);
  distributed.render(part.view(), builtin_camera(100, 80), {}, frame);
}

TEST_CASE("mpi agreement: when ranks have met the first has heard all steps") {
  const auto others = std::size_t(ranks_here().size() - 1);
  for (int round = 0; round < 100; ++round) {
    if (ranks_here().rank() != 0)
      for (int k = 0; k < 3; ++k) ranks_here().tell_step();
    ranks_here().meet([] {});
    if (ranks_here().rank() == 0) {
      CHECK(ranks_here().steps_told() == 3 * others);
      CHECK(ranks_here().steps_told() == 0);
    }
    ranks_here().all(true);  // nobody tells steps of the next round before
  }
}

TEST_CASE("mpi agreement: arguments that one rank finds wrong are told to all") {
  DistributedRenderer<Cpu, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
  const auto part = distributed.backend().upload(make_builtin_scene(500, own_part()));
  const Camera cameras[] = {builtin_camera(100, 80), builtin_camera(60, 50)};
  Frame frames[2];
  // Rank 0 alone brings frames, and brings too few.
  if (ranks_here().rank() == 0)
    CHECK_THROWS_WITH_AS(distributed.render(part.view(), {cameras, 2}, {}, {frames, 1}),
                         "render: the number of frames is 1, expected 2, one a camera",
                         std::invalid_argument);
  else
    CHECK_THROWS_WITH_AS(distributed.render(part.view(), {cameras, 2}, {}, {frames, 0}),
                         "rank 0: render: the number of frames is 1, expected 2, one a camera", RankError);
  distributed.render(part.view(), {cameras, 2}, {}, {frames, 2});
}
