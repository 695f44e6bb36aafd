// SPDX-License-Identifier: Apache-2.0

// What ranks with devices do beside what hosts do, on a backend that everyone has.
#include <vector>

#include <doctest/doctest.h>

#include "mpi/away.hpp"
#include "mpi/compare.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE("mpi staging: frames of few and of many splats and views may take turns") {
  const Scene scene = make_builtin_scene(3'000);
  Renderer<Serial, EarlySort, PerPixel, Ellipse> one;
  const auto whole = one.backend().upload(scene);
  for (const bool direct : {false, true}) {
    ranks_here().set_direct(direct);
    DistributedRenderer<Away, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
    ranks_here().set_direct(false);
    CHECK(distributed.carrier() == (direct ? "away" : "host"));
    const auto part = distributed.backend().upload(part_of(scene, own_part()));
    for (const std::vector<Camera>& cameras :
         {std::vector{builtin_camera(40, 20)}, some_cameras(), std::vector{builtin_camera(300, 200)},
          std::vector{builtin_camera(40, 20)}, some_cameras()}) {
      const Span<const Camera> all{cameras.data(), cameras.size()};
      std::vector<Frame> expected(cameras.size()), found(cameras.size());
      one.render(whole, all, all_outputs(), {expected.data(), expected.size()});
      distributed.render(part.view(), all, all_outputs(), {found.data(), found.size()});
      if (ranks_here().rank() == 0)
        for (std::size_t i = 0; i < cameras.size(); ++i) CHECK(same_planes(found[i], expected[i]));
    }
  }
}

TEST_CASE("mpi staging: a link carries what goes by way of other memory otherwise") {
  const Camera camera = builtin_camera(190, 130);
  Frame frame;
  std::vector<FrameCounters> counters;
  for (const bool direct : {false, true}) {
    ranks_here().set_direct(direct);
    DistributedRenderer<Away, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
    const auto part = distributed.backend().upload(make_builtin_scene(2'000, own_part()));
    // In the first frame strips are as even by rows as can be: later ones go by the clock.
    distributed.render(part.view(), camera, {}, frame);
    counters.push_back(distributed.counters());
  }
  ranks_here().set_direct(false);
  CHECK(counters[0].sent_bytes() == counters[1].sent_bytes());
  CHECK(counters[0].messages() == counters[1].messages());
  CHECK((counters[0].sent_bytes() > 0) == (ranks_here().size() > 1));
}

TEST_CASE("mpi staging: one rank alone that wants no link leaves all without") {
  ranks_here().set_direct(ranks_here().rank() != 0);
  const DistributedRenderer<Away, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
  ranks_here().set_direct(false);
  CHECK(distributed.carrier() == "host");
}

TEST_CASE("mpi staging: strips that stay with their ranks have the bits of one process") {
  const Scene scene = make_builtin_scene(2'000);
  const Camera camera = builtin_camera(190, 130);
  Renderer<Serial, EarlySort, PerPixel, Ellipse> one;
  Frame expected;
  one.render(one.backend().upload(scene), camera, all_outputs(), expected);
  DistributedRenderer<Away, EarlySort, PerPixel, Ellipse> distributed(ranks_here());
  const auto part = distributed.backend().upload(part_of(scene, own_part()));
  std::uint64_t rows = 0;
  for (const DrawnStrip& each : distributed.render_strips(part.view(), {&camera, 1}, all_outputs())) {
    const std::size_t first = std::size_t(each.view_strip.first_row) * 190,
                      size = std::size_t(each.view_strip.rows) * 190;
    CHECK(std::memcmp(each.frame.colour.data, &expected.colour[3 * first], 3 * size * sizeof(float)) == 0);
    CHECK(std::memcmp(each.frame.depth.data, &expected.depth[first], size * sizeof(float)) == 0);
    rows += std::uint64_t(each.view_strip.rows);
  }
  ranks_here().add_up({&rows, 1});
  CHECK(rows == 130);
}
