// SPDX-License-Identifier: Apache-2.0

// What the CUDA backend promises as a backend, loops over functors apart.
#include <utility>

#include "cuda/device.hpp"
#include "policies/pairs.hpp"
#include "policies/views.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

SWIFTGS_DEVICE_CASE("cuda: sort_pairs sorts as many pairs as end a tile or a group of tiles, or nearly") {
  Cuda cuda;
  for (const std::size_t tile : {768, 1024, 4096})
    for (const std::size_t tiles : {1, 2, 7, 8, 9, 16, 63, 64, 65, 129})
      for (const int beyond : {-1, 0, 1}) {
        const std::size_t n = tile * tiles + std::size_t(beyond);
        CAPTURE(n);
        CHECK(sorts(cuda, random_keys<std::uint16_t>(n, 5), 13));
        CHECK(sorts(cuda, random_keys<std::uint32_t>(n, 6), 31));
        CHECK(sorts(cuda, random_keys<std::uint64_t>(n, 7), 44));
      }
  // Tiles become larger where there are two for each multiprocessor.
  const std::size_t tiles = 2 * std::size_t(cuda.multiprocessors());
  for (const std::size_t tile : {1536, 2048, 3072, 4096})
    for (const std::size_t n : {(tiles - 1) * tile, (tiles - 1) * tile + 1, tiles * tile + 1}) {
      CAPTURE(n);
      CHECK(sorts(cuda, random_keys<std::uint16_t>(n, n), 13));
      CHECK(sorts(cuda, random_keys<std::uint32_t>(n, n), 31));
      CHECK(sorts(cuda, random_keys<std::uint64_t>(n, n), 44));
    }
}

SWIFTGS_DEVICE_CASE("cuda: sort_positions sorts the positions of keys, and leaves the keys as they are") {
  Cuda cuda;
  Pairs<Cuda, std::uint32_t> pairs;
  for (const std::size_t n : {0, 1, 1023, 1024, 1025, 30'001, 700'000, 1'200'000, 5}) {
    CAPTURE(n);
    std::vector<std::uint32_t> keys = random_keys<std::uint32_t>(n, n + 1), positions(n);
    for (std::size_t i = 0; i < n; ++i) keys[i] &= 0x7fff00ff, positions[i] = std::uint32_t(i);
    const DeviceBuffer<std::uint32_t> unsorted = to_device(keys);
    cuda.sort_positions(unsorted.data(), n, 31, pairs);
    CHECK(to_host(cuda, unsorted.span()) == keys);
    stable_sort_pairs(keys, positions, 31);
    CHECK(to_host(cuda, Span<const std::uint32_t>{pairs.values.data(), n}) == positions);
    CHECK(to_host(cuda, Span<const std::uint32_t>{pairs.keys.data(), n}) == keys);
  }
}

SWIFTGS_DEVICE_CASE("cuda: sort_pairs keeps the order of the highest keys, which tiles are padded with") {
  Cuda cuda;
  for (const int bits : {5, 8, 13, 16}) {
    CAPTURE(bits);
    CHECK(sorts(cuda, std::vector<std::uint16_t>(10'001, 0xffff), bits));
    std::vector<std::uint16_t> keys = random_keys<std::uint16_t>(70'001, 8);
    for (std::size_t i = 0; i < keys.size(); i += 2) keys[i] = 0xffff;
    CHECK(sorts(cuda, keys, bits));
  }
}

SWIFTGS_DEVICE_CASE("cuda: sort_pairs refuses more pairs than it can number") {
  Cuda cuda;
  Pairs<Cuda, std::uint32_t> pairs;
  CHECK_THROWS_AS(cuda.sort_pairs(pairs, std::size_t(1) << 32, 31), CapacityError);
}

SWIFTGS_DEVICE_CASE("cuda: work of a fork comes after what precedes it and before what follows the join") {
  Cuda cuda;
  DeviceBuffer<std::uint8_t> memory, copy;
  memory.reset(std::size_t(1) << 26), copy.reset(memory.size());
  const std::size_t last = memory.size() - 1;
  std::uint8_t seen = 0;
  for (std::uint8_t round = 1; round < 50; ++round) {
    check_cuda(cudaMemsetAsync(memory.data(), 0, memory.size(), cuda.stream()), "cudaMemsetAsync");
    {
      Cuda::Fork fork = cuda.fork();
      check_cuda(cudaMemsetAsync(memory.data(), round, memory.size(), fork.stream()), "cudaMemsetAsync");
      CHECK_THROWS_AS((void)cuda.fork(), std::logic_error);
      if (round % 2) fork.join();  // else the destructor does
    }
    copy_on_device(memory.data(), copy.data(), memory.size(), cuda.stream());
    cuda.download(Span<const std::uint8_t>{copy.data() + last, 1}, &seen);
    CHECK(seen == round);
  }
}

SWIFTGS_DEVICE_CASE("cuda: an uploaded scene is copied without bands that are zero throughout") {
  const Cuda cuda;
  Scene scene = random_scene(300, 3, 6);
  // Whether all is there, and for each Gaussian the coefficients of `degree` bands.
  const auto holds = [&](const DeviceScene& uploaded, int degree) {
    const SceneView view = uploaded.view();
    const std::size_t used = 3 * std::size_t(sh_rest_count(degree));
    const std::vector<float> rest = to_host(cuda, view.sh_rest, used);
    bool same = view.sh_degree == degree && view.sh_rest.stride < (used + 16) * sizeof(float);
    for (std::size_t i = 0; same && i < scene.size(); ++i)
      same = std::equal(&scene.sh_rest[45 * i], &scene.sh_rest[45 * i] + used, rest.data() + used * i);
    return same && same_bits(to_host(cuda, view.means), scene.means) &&
           same_bits(to_host(cuda, view.scales), scene.scales) &&
           same_bits(to_host(cuda, view.rotations), scene.rotations) &&
           same_bits(to_host(cuda, view.opacities), scene.opacities) &&
           same_bits(to_host(cuda, view.sh0), scene.sh0);
  };
  CHECK(holds(cuda.upload(scene), 3));
  for (const int degree : {2, 1, 0}) {
    CAPTURE(degree);
    const std::size_t used = 3 * std::size_t(sh_rest_count(degree));
    for (std::size_t i = 0; i < scene.sh_rest.size(); ++i)
      if (i % 45 >= used) scene.sh_rest[i] = 0;
    CHECK(holds(cuda.upload(std::make_shared<const Scene>(scene)), degree));
  }

  CHECK(cuda.upload(Scene()).view().size() == 0);
}

SWIFTGS_DEVICE_CASE("cuda: the clock is read without waiting and may be asked before its work is done") {
  Cuda cuda;
  DeviceBuffer<std::uint32_t> memory = to_device(std::vector<std::uint32_t>(50'000'000));
  const auto from = cuda.now();
  for (int i = 0; i < 200; ++i) cuda.clear(memory.data(), memory.size() * sizeof(std::uint32_t));
  const auto to = cuda.now();
  const std::optional<double> early = cuda.milliseconds(from, to);
  // That it was asked too early is no error of the calls that follow.
  CHECK_NOTHROW(cuda.exclusive_scan(memory.span()));
  CHECK(cudaGetLastError() == cudaSuccess);
  const std::optional<double> ms = cuda.milliseconds(from, to);
  REQUIRE(ms);
  CHECK(*ms > 0.1);
  CHECK(*ms < 60'000);
  if (early) CHECK(*early == *ms);
}

SWIFTGS_DEVICE_CASE("cuda: a point in time can be read until 255 later ones have been taken") {
  Cuda cuda;
  const auto wait = [&] { check_cuda(cudaStreamSynchronize(cuda.stream()), "cudaStreamSynchronize"); };
  CHECK_FALSE(cuda.milliseconds({}, cuda.now()));
  const auto from = cuda.now(), to = cuda.now();
  CHECK_FALSE(cuda.milliseconds(to, from));
  for (int i = 0; i < 254; ++i) cuda.now();
  wait();
  CHECK(cuda.milliseconds(from, to));
  cuda.now();
  wait();
  CHECK_FALSE(cuda.milliseconds(from, to));
  const auto late = cuda.now();
  wait();
  CHECK(cuda.milliseconds(to, late).has_value() == false);
  CHECK(cuda.milliseconds(late, late) == 0.0);
}

SWIFTGS_DEVICE_CASE("cuda: each report is of what the counts were when they were settled") {
  const Cuda cuda;
  DeviceBuffer<FrameCounts> counts;
  DeviceBuffer<FrameTotals> totals;
  totals.reset(1);
  for (std::uint64_t i = 1; i < 200; ++i) {
    const FrameCounts written{i, i << 33};
    copy_to_device(Span<const FrameCounts>{&written, 1}, counts);
    cuda.settle({counts.data()}, {}, totals.data());
    const FrameReport found = cuda.await_report();
    CHECK(found.visible == written.visible);
    CHECK(found.intersections == written.intersections);
  }
}

SWIFTGS_DEVICE_CASE("cuda: later stages go by totals that are zero where a frame does not fit its limits") {
  const Cuda cuda;
  const DeviceBuffer<FrameCounts> counts = to_device(std::vector<FrameCounts>{{100, 2000}});
  DeviceBuffer<FrameTotals> totals;
  totals.reset(1);
  Report<Cuda> report;
  const auto settled = [&](const Limits& limits) {
    cuda.settle({counts.data()}, limits, totals.data());
    return to_host(cuda, std::as_const(totals).span())[0];
  };
  for (const Capacity& enough : {Capacity{}, Capacity{100, 2000}, Capacity{100, 0}, Capacity{0, 2000}}) {
    const FrameTotals found = settled({.capacity = enough, .report = report.data()});
    CHECK(found.splats == 100);
    CHECK(found.intersections == 2000);
    CHECK(report.get(cuda).overflowed == 0);
  }
  for (const Limits& none : {Limits{.capacity = {99, 2000}}, Limits{.capacity = {100, 1999}},
                             Limits{.capacity = {}, .draw = false}}) {
    Limits limits = none;
    limits.report = report.data();
    const FrameTotals found = settled(limits);
    CHECK(found.splats == 0);
    CHECK(found.intersections == 0);
    const FrameReport told = report.get(cuda);
    CHECK(told.overflowed == 1);
    CHECK(told.visible == 100);
    CHECK(told.intersections == 2000);
  }
  CHECK_THROWS_AS((void)cuda.await_report(), std::logic_error);
}

SWIFTGS_DEVICE_CASE("cuda: counters of the last operation are those of the epoch before the next") {
  const Cuda cuda;
  const DeviceBuffer<FrameCounts> copies = to_device(std::vector<FrameCounts>{{1, 2}, {3, 4}});
  DeviceBuffer<FrameTotals> totals;
  totals.reset(1);
  for (const std::uint32_t next : {0u, 1u, 2u, 3u, kernels::epochs_in_all - 1}) {
    CAPTURE(next);
    const DeviceBuffer<std::uint32_t> epoch = to_device(std::vector<std::uint32_t>{next});
    cuda.settle({copies.data(), epoch.data()}, {}, totals.data());
    CHECK(cuda.await_report().visible == (next % 2 ? 1 : 3));
  }
}

SWIFTGS_DEVICE_CASE("cuda: a backend has as many multiprocessors as its device") {
  const Cuda cuda;
  int device = 0, count = 0;
  check_cuda(cudaGetDevice(&device), "cudaGetDevice");
  check_cuda(cudaDeviceGetAttribute(&count, cudaDevAttrMultiProcessorCount, device),
             "cudaDeviceGetAttribute");
  CHECK(cuda.multiprocessors() == count);
  CHECK(cuda.multiprocessors() == count);
}

SWIFTGS_DEVICE_CASE("cuda: a backend that was moved works where it went") {
  const Stream stream;
  Cuda first(stream.get());
  const auto scans = [](Cuda& cuda) {
    DeviceBuffer<std::uint32_t> counts = to_device(std::vector<std::uint32_t>{5, 6, 7});
    return cuda.exclusive_scan(counts.span()) == 18;
  };
  CHECK(scans(first));
  Cuda second(std::move(first));
  CHECK(second.stream() == stream.get());
  CHECK(scans(second));
  Cuda third;
  third = std::move(second);
  CHECK(third.stream() == stream.get());
  CHECK(scans(third));
  first = Cuda();
  CHECK(first.stream() == nullptr);
  CHECK(scans(first));
}
