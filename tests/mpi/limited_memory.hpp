// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/frame/backend.hpp>

#include "mpi/compare.hpp"

namespace swiftgs::test {

/// Memory of a hook until it ends, or is asked for too much at once.
struct LimitedMemory {
  MemoryHook of;
  std::size_t left = 1000000;                                        ///< allocations
  std::size_t most_bytes = std::numeric_limits<std::size_t>::max();  ///< of one
  std::size_t largest = 0;                                           ///< so far @units{bytes}

  static void* allocate(void* self, std::size_t bytes) {
    auto& limited = *static_cast<LimitedMemory*>(self);
    if (limited.left == 0 || bytes > limited.most_bytes)
      throw CapacityError("bytes for this test", bytes, limited.left == 0 ? 0 : limited.most_bytes);
    --limited.left, limited.largest = std::max(limited.largest, bytes);
    return limited.of.allocate(limited.of.context, bytes);
  }
  static void release(void* self, void* memory, std::size_t bytes) {
    const MemoryHook& of = static_cast<LimitedMemory*>(self)->of;
    of.release(of.context, memory, bytes);
  }
};

/// Ends the last rank's memory at every allocation of a frame in turn, until a frame needs no more. `make`
/// makes a backend that takes memory from a hook; all ranks throw until then.
template <class B, class Make>
void fail_at_each_allocation(const MemoryHook& memory, const Make& make,
                             const RenderSettings& settings = all_outputs()) {
  const Scene scene = make_builtin_scene(2'000);
  const Camera camera = builtin_camera(100, 75);
  Renderer<B, EarlySort, PerPixel, Ellipse> one;
  Frame expected, found;
  one.render(one.backend().upload(scene), camera, settings, expected);

  LimitedMemory limited{memory};
  DistributedRenderer<B, EarlySort, PerPixel, Ellipse> distributed(
      ranks_here(), make(MemoryHook{LimitedMemory::allocate, LimitedMemory::release, &limited}));
  CAPTURE(distributed.carrier());
  const auto part = distributed.backend().upload(part_of(scene, own_part()));
  const int last = ranks_here().size() - 1;
  int failures = 0;
  for (std::size_t allowed = 0; allowed < 100; ++allowed) {
    if (ranks_here().rank() == last) limited.left = allowed % 3;
    const std::string message =
        message_of<CapacityError>(last, [&] { distributed.render(part.view(), camera, settings, found); });
    const bool failed = !message.empty();
    CHECK(ranks_here().all(failed) == !ranks_here().all(!failed));  // all or none
    if (failed) {
      ++failures;
      CHECK(message.find("bytes for this test: ") != std::string::npos);
      continue;
    }
    if (ranks_here().rank() == 0) CHECK(same_planes(found, expected));
    break;
  }
  CHECK(failures > 3);
}

/// A frame for which one rank has no memory fails on all, and smaller frames are drawn as before.
template <class B, class Make>
void draw_after_too_large_a_frame(const MemoryHook& memory, const Make& make) {
  const Scene scene = make_builtin_scene(60'000);
  const Camera small = builtin_camera(96, 64), large = builtin_camera(2400, 1350);
  Renderer<B, EarlySort, PerPixel, Ellipse> one;
  Frame expected, found;
  one.render(one.backend().upload(part_of(scene, {0, 20})), small, all_outputs(), expected);

  LimitedMemory limited{memory};
  DistributedRenderer<B, EarlySort, PerPixel, Ellipse> distributed(
      ranks_here(), make(MemoryHook{LimitedMemory::allocate, LimitedMemory::release, &limited}));
  CAPTURE(distributed.carrier());
  // Few Gaussians, then all of them.
  const auto few = distributed.backend().upload(part_of(part_of(scene, {0, 20}), own_part()));
  const auto all = distributed.backend().upload(part_of(scene, own_part()));
  limited.largest = 0;
  distributed.render(few.view(), small, all_outputs(), found);
  const int last = ranks_here().size() - 1;
  if (ranks_here().rank() == last) limited.most_bytes = 2 * limited.largest;
  const std::string message =
      message_of<CapacityError>(last, [&] { distributed.render(all.view(), large, all_outputs(), found); });
  CHECK(message.find("bytes for this test: ") != std::string::npos);
  CHECK(distributed.drawn().size == 0);
  CHECK(distributed.counters().ranks.empty());
  for (int k = 0; k < 2; ++k) {
    distributed.render(few.view(), small, all_outputs(), found);
    if (ranks_here().rank() == 0) CHECK(same_planes(found, expected));
  }
}

}  // namespace swiftgs::test
