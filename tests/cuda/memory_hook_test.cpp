// SPDX-License-Identifier: Apache-2.0

// Device memory of `Cuda` from a pool that works in the order of its stream.
#include <cstddef>
#include <deque>
#include <vector>

#include "cuda/device.hpp"
#include "cuda/stream_pool.hpp"
#include "policies/hooked.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

SWIFTGS_DEVICE_CASES("cuda memory hook: growing and going keep the stream's order", Sort, StandardSort,
                     EarlySort, AdaptiveSort) {
  const Scene scene = random_scene(40000, 3, 1);
  const Stream stream;
  Usual<Cuda, Sort> plain;
  const DeviceScene uploaded = plain.backend().upload(scene);
  constexpr int rounds = 12;
  std::vector<std::vector<PlanesMemory>> expected;
  std::deque<PlacedViews<Cuda>> images;
  for (int i = 0; i < rounds; ++i) {
    // Sizes that go up and down, so that memory of one renderer soon becomes that of the next.
    const std::vector<AskedView> asked = asked_of(i, 1 + i % 3, 1.25 + 0.5 * (i % 4));
    images.emplace_back(plain.backend(), asked);
    expected.push_back(draw_together(plain, uploaded.view(), asked));
  }

  StreamPool pool(stream.get());
  {
    // Nothing here waits for the last kernels of a frame.
    Usual<Cuda, Sort> kept(Cuda(stream.get(), pool.hook()));
    for (int i = 0; i < rounds; ++i) {
      kept.render_into(uploaded.view(), images[std::size_t(i)].span());
      Usual<Cuda, Sort> gone(Cuda(stream.get(), pool.hook()));
      gone.render_into(uploaded.view(), images[std::size_t(i)].span());
    }
  }
  CHECK(pool.in_use() == 0);
  CHECK(pool.allocations() > 100);
  for (std::size_t i = 0; i < rounds; ++i)
    CHECK(differing(images[i].finish(Cuda(stream.get())), expected[i]) == 0);
}

SWIFTGS_DEVICE_CASE("cuda memory hook: a scene is taken from it and released with its last copy") {
  const Scene scene = random_scene(5000, 2, 2);
  const Stream stream;
  StreamPool pool(stream.get());
  Usual<Cuda> renderer(Cuda(stream.get(), pool.hook())), plain;
  const DeviceScene ordinary = plain.backend().upload(scene);
  PlacedViews images(plain.backend(), asked_of(0, 1));
  const auto expected = draw_together(plain, ordinary.view(), asked_of(0, 1));
  CHECK(pool.in_use() == 0);
  {
    const DeviceScene uploaded = renderer.backend().upload(scene);
    const std::size_t bytes = pool.in_use();
    CHECK(bytes >= 5000 * (56 + 96));
    const DeviceScene copy = uploaded;
    CHECK(pool.in_use() == bytes);
    renderer.render_into(copy.view(), images.span());
  }  // while the frame may still be under way
  CHECK(pool.in_use() >= renderer.memory().total());
  CHECK(renderer.memory().total() > 0);
  CHECK(differing(images.finish(renderer.backend()), expected) == 0);
  renderer.trim();
  CHECK(pool.in_use() == 0);
}
