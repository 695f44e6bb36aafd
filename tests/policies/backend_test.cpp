// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <memory>
#include <new>
#include <numeric>
#include <vector>

#include "policies/backends.hpp"
#include "policies/pairs.hpp"

using namespace swiftgs;
using swiftgs::test::make_backend;
using swiftgs::test::Random;
using swiftgs::test::random_keys;
using swiftgs::test::stable_sort_pairs;

namespace {

constexpr std::size_t interesting_sizes[] = {0, 1, 2, 3, 1000, 100'000};

/// Whether `backend` sorts `keys` exactly as a stable sort does, the values numbered in order.
template <class B, class Key>
bool sorts(B& backend, std::vector<Key> keys, int bits) {
  std::vector<std::uint32_t> values(keys.size());
  std::iota(values.begin(), values.end(), 7u);
  Pairs<B, Key> pairs;
  pairs.reset(keys.size());
  std::copy(keys.begin(), keys.end(), pairs.keys.data());
  std::copy(values.begin(), values.end(), pairs.values.data());
  backend.sort_pairs(pairs, keys.size(), bits);
  stable_sort_pairs(keys, values, bits);
  return std::equal(keys.begin(), keys.end(), pairs.keys.data()) &&
         std::equal(values.begin(), values.end(), pairs.values.data());
}

}  // namespace

TEST_CASE_TEMPLATE("backend: for_each visits each index exactly once", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  for (const std::size_t n : interesting_sizes) {
    CAPTURE(n);
    const auto visits = std::make_unique<std::atomic<int>[]>(n + 1);
    backend.for_each(n, [&](std::size_t i) { ++visits[std::min(i, n)]; });
    CHECK(std::all_of(visits.get(), visits.get() + n, [](const auto& count) { return count == 1; }));
    CHECK(visits[n] == 0);
  }
}

TEST_CASE_TEMPLATE("backend: exclusive_scan replaces each count by the sum before it", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  for (const std::size_t n : {0, 1, 2, 1000, 32'767, 32'768, 300'001}) {
    CAPTURE(n);
    Random random(n);
    std::vector<std::uint32_t> counts(n), expected(n);
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
      counts[i] = std::uint32_t(random.bits() % 100);
      expected[i] = std::uint32_t(sum);
      sum += counts[i];
    }
    CHECK(backend.exclusive_scan({counts.data(), n}) == sum);
    CHECK(counts == expected);
  }
}

TEST_CASE_TEMPLATE("backend: exclusive_scan returns totals beyond 32 bits", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  std::vector<std::uint32_t> counts(100'000, 0xffffffffu);
  CHECK(backend.exclusive_scan({counts.data(), counts.size()}) == 100'000 * std::uint64_t(0xffffffffu));
  std::vector<std::uint32_t> two = {0x80000000u, 0x80000000u};
  CHECK(backend.exclusive_scan({two.data(), 2}) == std::uint64_t(1) << 32);
}

TEST_CASE_TEMPLATE("backend: sort_pairs is a stable sort by the low bits alone", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  for (const std::size_t n : {0, 1, 2, 3, 257, 30'000}) {
    CAPTURE(n);
    for (int bits = 0; bits <= 32; ++bits) {
      CAPTURE(bits);
      CHECK(sorts(backend, random_keys<std::uint32_t>(n, 1), bits));
    }
    for (const int bits : {0, 1, 8, 11, 13, 14, 31, 32, 33, 43, 44, 55, 63, 64}) {
      CAPTURE(bits);
      CHECK(sorts(backend, random_keys<std::uint64_t>(n, 2), bits));
    }
  }
}

TEST_CASE_TEMPLATE("backend: sort_pairs keeps the order of 100000 equal keys", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  CHECK(sorts(backend, std::vector<std::uint32_t>(100'000, 0xdeadbeefu), 31));
  CHECK(sorts(backend, std::vector<std::uint64_t>(100'000, 0xdeadbeef12345678u), 44));
  CHECK(sorts(backend, random_keys<std::uint64_t>(100'000, 3), 44));
}

TEST_CASE_TEMPLATE("backend: sort_pairs sorts by every digit when only one digit differs", B,
                   SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  for (int bit = 0; bit < 44; ++bit) {
    CAPTURE(bit);
    std::vector<std::uint64_t> keys(20'000, 0x5a5a5a5a5a5a5a5au);
    for (std::size_t i = 0; i < keys.size(); i += 3) keys[i] ^= std::uint64_t(1) << bit;
    CHECK(sorts(backend, keys, 44));
  }
}

TEST_CASE("cpu: sort and scan give the same result on 1 2 4 and 8 threads") {
  for (const int threads : {1, 2, 4, 8}) {
    CAPTURE(threads);
    Cpu backend(threads);
    CHECK(backend.threads() == threads);
    CHECK(sorts(backend, random_keys<std::uint32_t>(200'000, 4), 17));
    CHECK(sorts(backend, random_keys<std::uint64_t>(200'000, 5), 44));
    std::vector<std::uint32_t> counts(200'000, 3);
    CHECK(backend.exclusive_scan({counts.data(), counts.size()}) == 600'000);
    CHECK(counts[123'456] == 3 * 123'456);
  }
}

TEST_CASE_TEMPLATE("backend: an uploaded scene is shared and seen as it is", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const auto scene = std::make_shared<const Scene>(swiftgs::test::random_scene(10, 2, 6));
  const SceneView view = backend.upload(scene).view();
  CHECK(view.means.data == scene->means.data());
  CHECK(view.size() == 10);
  CHECK(view.sh_degree == 2);
  CHECK(view.sh_stride == 24);
  CHECK_THROWS_AS(backend.upload(std::shared_ptr<const Scene>()), std::invalid_argument);
  Scene broken = *scene;
  broken.opacities.pop_back();
  CHECK_THROWS_WITH_AS(backend.upload(broken), "scene: opacities has 9 elements, expected 10",
                       std::invalid_argument);
}

TEST_CASE_TEMPLATE("backend: its clock runs forwards and is read without waiting", B, SWIFTGS_TEST_BACKENDS) {
  B backend = make_backend<B>();
  const auto from = backend.now();
  const std::optional<double> ms = backend.milliseconds(from, backend.now());
  REQUIRE(ms);
  CHECK(*ms >= 0);
  CHECK(*ms < 60'000);
}

TEST_CASE("growing buffer: grows and never shrinks and is aligned to a cache line") {
  GrowingBuffer<float> buffer;
  buffer.reset(1000);
  const float* memory = buffer.data();
  const std::size_t capacity = buffer.capacity();
  CHECK(buffer.size() == 1000);
  CHECK(capacity >= 1000);
  CHECK(std::uintptr_t(memory) % 64 == 0);
  buffer.reset(10);
  CHECK(buffer.size() == 10);
  CHECK(buffer.capacity() == capacity);
  buffer.reset(1000);
  CHECK(buffer.data() == memory);
}

#if !defined(__SANITIZE_ADDRESS__)  // which ends the program instead of throwing
TEST_CASE("growing buffer: is empty after memory could not be had") {
  GrowingBuffer<float> buffer;
  buffer.reset(10);
  CHECK_THROWS_AS(buffer.reset(std::size_t(1) << 58), std::bad_alloc);
  CHECK(buffer.size() == 0);
  CHECK(buffer.span().empty());
  buffer.reset(10);
  CHECK(buffer.data() != nullptr);
}
#endif
