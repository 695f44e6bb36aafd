// SPDX-License-Identifier: Apache-2.0

// What one rank finds wrong, all ranks learn.
#include <stdexcept>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/cpu.hpp>

#include "mpi/compare.hpp"
#include "mpi/limited_memory.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE("mpi agreement: where one rank fails all throw and can go on") {
  fail_at_each_allocation<Cpu>(hook_of<CacheLineMemory>(),
                               [](const MemoryHook& memory) { return Cpu(1, memory); });
}

TEST_CASE("mpi agreement: a frame that one rank has no memory for leaves smaller ones as they were") {
  draw_after_too_large_a_frame<Cpu>(hook_of<CacheLineMemory>(),
                                    [](const MemoryHook& memory) { return Cpu(1, memory); });
}

TEST_CASE("mpi agreement: views that differ between ranks are refused on all of them") {
  if (ranks_here().size() == 1) return;
  DistributedRenderer<Cpu, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
  const auto part = distributed.backend().upload(make_builtin_scene(500, own_part()));
  const Camera camera = builtin_camera(100, 80);
  Frame frame;
  const auto refuses = [&](const Camera& own_camera, const Outputs& own_outputs) {
    RenderSettings settings;
    settings.outputs = own_outputs;
    CHECK_THROWS_WITH_AS(
        distributed.render(part.view(), own_camera, settings, frame),
        "render: the views of rank 1 differ from those of rank 0, expected the same on all ranks",
        std::invalid_argument);
    distributed.render(part.view(), camera, {}, frame);
    if (ranks_here().rank() == 0) CHECK(frame.width == 100);
  };
  const bool other = ranks_here().rank() == 1;
  Camera larger = camera;
  larger.fx *= 1.0001;
  refuses(other ? larger : camera, {});
  for (const Outputs& asked : {Outputs{.alpha = true}, Outputs{.normal = true}, Outputs{.id = true}})
    refuses(camera, other ? asked : Outputs());
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
  const std::size_t brought = ranks_here().rank() == 0 ? 1 : 0;
  const std::string message = message_of<std::invalid_argument>(0, [&] {
    distributed.render(part.view(), {cameras, 2}, {}, {frames, brought});
  });
  const std::string teller = brought ? "" : "rank 0: ";
  CHECK(message == teller + "render: the number of frames is 1, expected 2, one a camera");
  distributed.render(part.view(), {cameras, 2}, {}, {frames, 2});
}

TEST_CASE("mpi agreement: ranks learn the code of the error of another") {
  Failure failure;
  if (ranks_here().rank() == 0) failure.guard([] { throw CapacityError("splats", 2, 1); });
  try {
    failure.agree(ranks_here());
    FAIL_CHECK("expected an error");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::capacity);
  }
}
