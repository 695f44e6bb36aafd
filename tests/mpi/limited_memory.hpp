// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <doctest/doctest.h>

#include <swiftgs/memory_hook.hpp>

#include "mpi/compare.hpp"

namespace swiftgs::test {

/// Memory of a hook until it ends.
struct LimitedMemory {
  MemoryHook of;
  std::size_t left = 1000000;  ///< allocations

  static void* allocate(void* self, std::size_t bytes) {
    auto& [of, left] = *static_cast<LimitedMemory*>(self);
    if (left == 0) throw CapacityError("bytes for this test", bytes, 0);
    --left;
    return of.allocate(of.context, bytes);
  }
  static void release(void* self, void* memory, std::size_t bytes) {
    const MemoryHook& of = static_cast<LimitedMemory*>(self)->of;
    of.release(of.context, memory, bytes);
  }
};

/// Ends the last rank's memory at every allocation of a frame in turn, until a frame needs no more. `make`
/// makes a backend that takes memory from a hook; all ranks throw until then.
template <class B, class Make>
void fail_at_each_allocation(const MemoryHook& memory, const Make& make) {
  const Scene scene = make_builtin_scene(2'000);
  const Camera camera = builtin_camera(200, 150);
  Renderer<B, EarlySort, PerPixel, Ellipse> one;
  Frame expected, found;
  one.render(one.backend().upload(scene), camera, all_outputs(), expected);

  LimitedMemory limited{memory};
  DistributedRenderer<B, EarlySort, PerPixel, Ellipse> distributed(
      ranks_here(), make(MemoryHook{LimitedMemory::allocate, LimitedMemory::release, &limited}));
  CAPTURE(distributed.carrier());
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

}  // namespace swiftgs::test
