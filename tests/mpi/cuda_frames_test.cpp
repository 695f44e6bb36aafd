// SPDX-License-Identifier: Apache-2.0

// Frames over ranks with a device each, or one that they share, have the bits of one process.
#include <cstdint>
#include <cstdlib>
#include <set>
#include <string>
#include <vector>

#include <dlfcn.h>
#include <doctest/doctest.h>

#include <swiftgs/mpi/cuda.hpp>

#include "mpi/compare.hpp"
#include "mpi/limited_memory.hpp"
#include "support/skip.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

#if defined(SWIFTGS_HAS_NCCL)
const bool has_nccl = dlopen("libnccl.so.2", RTLD_NOW) != nullptr;
#else
constexpr bool has_nccl = false;
#endif

/// Whether all ranks have a device; each takes one.
bool on_devices() {
  const bool usable = ranks_here().all(Cuda::usable());
  if (usable)
    take_device(ranks_here());
  else
    skip("no GPU here");
  return usable;
}

/// What carries splats where ranks may choose.
std::string chosen_carrier() {
  ranks_here().set_direct(true);
  const DistributedRenderer<Cuda, EarlySort, PerPixel, Ellipse> renderer(ranks_here());
  return std::string(renderer.carrier());
}

/// f() by way of the host, and from device to device where ranks have one each and the build has NCCL.
template <class F>
void with_each_carrier(const F& f) {
  const bool has_direct = chosen_carrier() != "host";
  ranks_here().set_direct(false);
  f();
  ranks_here().set_direct(true);
  if (has_direct) f();
}

template <class Sort, class Raster, class Bounds>
void compare_carriers(const Scene& scene, const std::vector<Camera>& cameras, int frames = 3) {
  with_each_carrier([&] { compare<Cuda, Sort, Raster, Bounds>(scene, cameras, frames); });
}

}  // namespace

TEST_CASE("mpi cuda: devices exchange without the host where each rank has one and the build has NCCL") {
  if (!on_devices()) return;
  const std::string carrier = chosen_carrier();
  if (ranks_here().rank() == 0) MESSAGE("splats go by ", carrier);
  ranks_here().require_same("the carrier", carrier);
  // Ranks of one machine.
  const std::vector<int> devices = ranks_here().all_gather(take_device(ranks_here()));
  const bool apart = std::set<int>(devices.begin(), devices.end()).size() == devices.size();
  const char* const shares = std::getenv("NCCL_MULTI_RANK_GPU_ENABLE");
  const bool may = apart || (shares && std::string(shares) == "1");
  CHECK(carrier == (has_nccl && may && devices.size() > 1 ? "nccl" : "host"));
}

TEST_CASE("mpi cuda: one rank alone that wants no link leaves all without") {
  if (!on_devices()) return;
  ranks_here().set_direct(ranks_here().rank() != 0);
  const DistributedRenderer<Cuda, EarlySort, PerPixel, Ellipse> renderer(ranks_here());
  CHECK(renderer.carrier() == "host");
}

TEST_CASE("mpi cuda: where one rank fails all throw and can go on") {
  if (!on_devices()) return;
  with_each_carrier([] {
    fail_at_each_allocation<Cuda>(hook_of<DeviceMemory>(),
                                  [](const MemoryHook& memory) { return Cuda(nullptr, memory); });
  });
}

TEST_CASE("mpi cuda: a frame that one rank has no memory for leaves smaller ones as they were") {
  if (!on_devices()) return;
  with_each_carrier([] {
    draw_after_too_large_a_frame<Cuda>(hook_of<DeviceMemory>(),
                                       [](const MemoryHook& memory) { return Cuda(nullptr, memory); });
  });
}

TEST_CASE("mpi cuda: each policy draws the bits of one process") {
  if (!on_devices()) return;
  const Scene scene = make_builtin_scene(30'000);
  const std::vector<Camera> cameras = some_cameras();
  for_every_policy([&]<class Sort, class Raster, class Bounds> {
    compare_carriers<Sort, Raster, Bounds>(scene, cameras);
  });
}

TEST_CASE("mpi cuda: all planes are the same") {
  if (!on_devices()) return;
  const Scene scene = with_features(make_builtin_scene(30'000)), own = part_of(scene, own_part());
  with_each_carrier([&] {
    compare<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>(scene, own, some_cameras(), 3,
                                                                          every_plane());
    compare<Cuda, StandardSort, PerPixel, Obb>(scene, own, {builtin_camera(333, 170)}, 2, every_plane());
  });
}

TEST_CASE("mpi cuda: a large frame with long lists draws the bits of one process") {
  if (!on_devices()) return;
  const Scene scene = make_builtin_scene(400'000);
  compare_carriers<EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>(scene, {builtin_camera(1280, 720)},
                                                                           4);
}

TEST_CASE("mpi cuda: ranks take coarser tiles where one process does") {
  if (!on_devices()) return;
  const Scene scene = make_builtin_scene(30'000);
  const std::vector<Camera> cameras{builtin_camera(1600, 1000)};
  compare_carriers<EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>(scene, cameras);
  DistributedRenderer<Cuda> renderer(ranks_here());
  const auto part = renderer.backend().upload(part_of(scene, own_part()));
  std::vector<std::uint64_t> rows;
  for (int k = 0; k < 2; ++k) {
    renderer.render_strips(part.view(), {cameras.data(), 1}, {});
    rows.push_back(0);
    for (const RankCounters& rank : renderer.counters().ranks) rows.back() += rank.rows;
  }
  CHECK(rows == std::vector<std::uint64_t>{63, 32});
}

TEST_CASE("mpi cuda: parts may be empty and messages cut") {
  if (!on_devices()) return;
  const Scene scene = make_builtin_scene(2'000);
  ranks_here().set_longest_message(5000);
  compare_carriers<EarlySort, PerPixel, Ellipse>(part_of(scene, {0, 1000}), {builtin_camera(120, 80)}, 2);
  compare_carriers<EarlySort, PerPixel, Ellipse>(Scene{}, {builtin_camera(120, 80)}, 2);
  compare_carriers<EarlySort, PerPixel, Ellipse>(scene, {builtin_camera(200, 17)}, 2);
  ranks_here().set_longest_message(std::size_t(1) << 30);
}
