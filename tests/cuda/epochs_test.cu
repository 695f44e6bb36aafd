// SPDX-License-Identifier: Apache-2.0

// Memory that projections, emissions and sorts hand on to the next: many in a row, of sizes that change, and
// where the numbers by which they tell new words from old ones begin again.
#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "cuda/device.hpp"
#include "policies/pairs.hpp"
#include "radix_sort.cuh"
#include "support/one_view.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// What `epochs` has on the device.
template <class Counters>
EpochsView<Counters> view_of(const Cuda& cuda, Epochs<Counters>& epochs) {
  const EpochsView<Counters> view = epochs.begin(cuda, 1);
  epochs.end();
  return view;
}

template <class Counters>
std::uint32_t epoch_of(const Cuda& cuda, Epochs<Counters>& epochs) {
  return to_host(cuda, Span<const std::uint32_t>{view_of(cuda, epochs).last().epoch, 1}).at(0);
}

template <class Counters>
void set_epoch(const Cuda& cuda, Epochs<Counters>& epochs, std::uint32_t epoch) {
  check_cuda(cudaMemcpyAsync(&view_of(cuda, epochs).counters->epoch, &epoch, sizeof epoch,
                             cudaMemcpyHostToDevice, cuda.stream()),
             "cudaMemcpyAsync");
  cuda.wait();
}

template <class Counters>
std::vector<std::uint64_t> words_of(const Cuda& cuda, Epochs<Counters>& epochs) {
  const EpochsView<Counters> view = view_of(cuda, epochs);
  return to_host(cuda, Span<const std::uint64_t>{view.words, view.capacity});
}

/// Sorts, and whether each is exactly a stable sort.
struct Sorting {
  static constexpr std::size_t row = RadixCounts::digits, small_rows = 1;

  Cuda cuda;
  Epochs<RadixCounts> epochs;

  template <class Key>
  bool sorts(std::size_t n, int bits, std::uint64_t seed) {
    std::vector<Key> keys = random_keys<Key>(n, seed);
    std::vector<std::uint32_t> values(n);
    std::iota(values.begin(), values.end(), 7u);
    Pairs<Cuda, Key> pairs;
    pairs.reset(n);
    copy_to_device(Span<const Key>{keys.data(), n}, pairs.keys);
    copy_to_device(Span<const std::uint32_t>{values.data(), n}, pairs.values);
    kernels::run_radix_sort(cuda, pairs, n, bits, epochs);
    stable_sort_pairs(keys, values, bits);
    return same_bits(to_host(cuda, Span<const Key>{pairs.keys.data(), n}), keys) &&
           same_bits(to_host(cuda, Span<const std::uint32_t>{pairs.values.data(), n}), values);
  }
  bool large(std::uint64_t seed) { return sorts<std::uint32_t>(40 * 1024, 24, seed); }
  bool small(std::uint64_t seed) { return sorts<std::uint16_t>(10, 13, seed); }
};

/// Projections, and whether each is that of a memory of its own.
struct Projecting {
  static constexpr std::size_t row = 1, small_rows = 1;

  Cuda cuda;
  ProjectScratch<Cuda> scratch;
  Epochs<FrameCounts>& epochs = scratch.epochs;

  std::tuple<SplatSet, std::uint64_t, std::vector<Footprint>> projected(const SceneView& scene,
                                                                        ProjectScratch<Cuda>& memory) {
    const OneView frame(forward_camera(320, 200), Conventions::gsplat(), scene);
    Splats<Cuda> splats;
    Footprints<Cuda> footprints;
    project(cuda, frame.plan(), Ellipse{}, memory, splats, footprints);
    bin(cuda, frame.plan(), Ellipse{}, splats, footprints);
    return {to_host(cuda, splats.view()), footprints.intersections.most,
            to_host(cuda, footprints.view().each)};
  }
  bool projects(std::size_t n, std::uint64_t seed) {
    const DeviceScene scene = cuda.upload(random_scene(n, 0, seed));
    ProjectScratch<Cuda> own;
    const auto [expected, tiles, of_each] = projected(scene.view(), own);
    const auto [found, tiles_found, of_each_found] = projected(scene.view(), scratch);
    return tiles_found == tiles && same_bits(of_each_found, of_each) &&
           same_bits(found.shapes, expected.shapes) && same_bits(found.depths, expected.depths) &&
           same_bits(found.gaussians, expected.gaussians);
  }
  bool large(std::uint64_t seed) { return projects(100 * 128, seed); }
  bool small(std::uint64_t seed) { return projects(10, seed); }
};

/// Emissions, and whether each is that of a memory of its own.
struct Emitting {
  static constexpr std::size_t row = 1, small_rows = 1;

  Cuda cuda;
  IntersectionScratch<Cuda> scratch;
  Epochs<std::uint32_t>& epochs = scratch.epochs;

  std::pair<std::vector<std::uint64_t>, std::vector<std::uint32_t>> emitted(
      const SortJob& job, IntersectionScratch<Cuda>& memory) {
    Pairs<Cuda, std::uint64_t> intersections;
    const std::size_t count = emit_intersections(cuda, job, Ellipse{}, nullptr, memory, intersections).most;
    return {to_host(cuda, Span<const std::uint64_t>{intersections.keys.data(), count}),
            to_host(cuda, Span<const std::uint32_t>{intersections.values.data(), count})};
  }
  bool emits(std::size_t n, std::uint64_t seed) {
    SplatSet splats = random_splats(n, 700, 500, seed);
    for (std::size_t i = 0; i < 3; ++i)
      splats.add(make_splat(300, 200, 400, 400, 0, 1), 1);  // without a mask
    const SplatsOn<Cuda> uploaded(cuda, splats);
    const Binned<Cuda, Ellipse> binned(cuda, uploaded.job(700, 500), Ellipse{});
    IntersectionScratch<Cuda> own;
    const auto expected = emitted(binned.job(), own), found = emitted(binned.job(), scratch);
    return expected.first.size() > n && same_bits(found.first, expected.first) &&
           same_bits(found.second, expected.second);
  }
  bool large(std::uint64_t seed) { return emits(100 * 256, seed); }
  bool small(std::uint64_t seed) { return emits(10, seed); }
};

}  // namespace

SWIFTGS_DEVICE_CASES("cuda epochs: what a larger operation left behind does not get into the next",
                     Operations, Sorting, Projecting, Emitting) {
  Operations operations;
  for (std::uint64_t i = 1; i < 40; ++i) {
    CAPTURE(i);
    CHECK(operations.large(i));
    for (std::uint64_t k = 0; k < i % 4; ++k) CHECK(operations.small(i + k));
  }
}

SWIFTGS_DEVICE_CASE("cuda epochs: sorts of every size and number of passes follow each other") {
  Sorting sorting;
  Random random(1);
  for (std::uint64_t i = 0; i < 100; ++i) {
    const std::size_t n = 1 + random.bits() % (i % 3 == 0 ? 100 : i % 3 == 1 ? 10'000 : 100'000);
    const int bits = 1 + int(random.bits() % 64);
    CAPTURE(n);
    CAPTURE(bits);
    const bool sorted = bits <= 16   ? sorting.sorts<std::uint16_t>(n, bits, i)
                        : bits <= 32 ? sorting.sorts<std::uint32_t>(n, bits, i)
                                     : sorting.sorts<std::uint64_t>(n, bits, i);
    CHECK(sorted);
  }
}

SWIFTGS_DEVICE_CASES(
    "cuda epochs: operations are counted on the device and begin again after the last number", Operations,
    Sorting, Projecting, Emitting) {
  Operations operations;
  CHECK(operations.large(1));
  CHECK(epoch_of(operations.cuda, operations.epochs) == 1);
  CHECK(operations.small(2));
  CHECK(epoch_of(operations.cuda, operations.epochs) == 2);
  CHECK(operations.large(3));
  set_epoch(operations.cuda, operations.epochs,
            kernels::epochs_in_all - 3);  // odd, as the number it replaces
  std::uint64_t seed = 4;
  for (const std::uint32_t next : {kernels::epochs_in_all - 2, kernels::epochs_in_all - 1, 0u, 1u, 2u}) {
    CAPTURE(next);
    const bool right = seed % 2 ? operations.large(seed) : operations.small(seed);
    CHECK(right);
    CHECK(epoch_of(operations.cuda, operations.epochs) == next);
    ++seed;
  }
}

SWIFTGS_DEVICE_CASE(
    "cuda epochs: sorts of fewer pairs keep the memory of a larger one, whatever their tiles") {
  Sorting sorting;
  // Tiles are of 4096, 2048 or 1024 pairs, by these numbers of them.
  const std::size_t tiles = 2 * std::size_t(sorting.cuda.multiprocessors());
  CHECK(sorting.sorts<std::uint32_t>(tiles * 4096 + 1, 9, 1));
  const std::uint64_t* const words = view_of(sorting.cuda, sorting.epochs).words;
  for (const std::size_t n : {(tiles - 1) * 4096, (tiles - 1) * 2048, tiles * 1024, std::size_t(1)}) {
    CAPTURE(n);
    CHECK(sorting.sorts<std::uint32_t>(n, 9, n));
    CHECK(view_of(sorting.cuda, sorting.epochs).words == words);
  }
}

SWIFTGS_DEVICE_CASES(
    "cuda epochs: smaller operations clear the words of a larger one before its number returns", Operations,
    Sorting, Projecting, Emitting) {
  Operations operations;
  CHECK(operations.large(1));
  const auto left = [&] {
    const std::vector<std::uint64_t> words = words_of(operations.cuda, operations.epochs);
    return std::count_if(words.begin() + Operations::small_rows * Operations::row, words.end(),
                         [](std::uint64_t word) { return word != 0; });
  };
  REQUIRE(left() > 30);
  const std::size_t rows = (view_of(operations.cuda, operations.epochs).mask + 1) / Operations::row;
  REQUIRE(rows < 200);
  std::size_t small = 0;
  for (; small < rows || small % 2 == 0; ++small) REQUIRE(operations.small(small));
  CHECK(left() == 0);
  REQUIRE(epoch_of(operations.cuda, operations.epochs) % 2 == 0);
  set_epoch(operations.cuda, operations.epochs, 0);
  CHECK(operations.large(2));
}

SWIFTGS_DEVICE_CASE("cuda epochs: a sort whose passes were not all started leaves nothing to the next") {
  Sorting sorting;
  CHECK(sorting.large(1));
  const DeviceBuffer<std::uint16_t> keys = to_device(random_keys<std::uint16_t>(5000, 2));
  launch("radix_histogram", kernels::radix_histogram<std::uint16_t>, kernels::histogram_blocks(5000),
         kernels::histogram_threads, sorting.cuda.stream(), keys.data(), 5000u, kernels::Digits(13),
         sorting.epochs.begin(sorting.cuda, 1));
  CHECK(sorting.small(3));
  CHECK(epoch_of(sorting.cuda, sorting.epochs) == 1);
  CHECK(sorting.large(4));
}
