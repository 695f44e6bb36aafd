// SPDX-License-Identifier: Apache-2.0

// What every backend promises: scans, sorts, uploads, clocks and buffers.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "policies/backends.hpp"
#include "policies/pairs.hpp"

namespace swiftgs::test::backend_test {

SWIFTGS_CASE_ON("backend: for_each visits each index exactly once", SWIFTGS_TEST_HOSTS) {
  for (const std::size_t n : {0, 1, 2, 3, 1000, 100'000}) {
    CAPTURE(n);
    const auto visits = std::make_unique<std::atomic<int>[]>(n + 1);
    backend.for_each(n, [&](std::size_t i) { ++visits[std::min(i, n)]; });
    CHECK(std::all_of(visits.get(), visits.get() + n, [](const auto& count) { return count == 1; }));
    CHECK(visits[n] == 0);
  }
}

namespace {

/// Whether `backend` replaces each count by the sum before it, and returns the sum of all.
template <class B>
bool scans(B& backend, const std::vector<std::uint32_t>& counts) {
  std::vector<std::uint32_t> expected;
  std::uint64_t sum = 0;
  for (const std::uint32_t count : counts) expected.push_back(std::uint32_t(sum)), sum += count;
  auto sums = to_backend(backend, counts);
  return backend.exclusive_scan(sums.span()) == sum &&
         to_host(backend, std::as_const(sums).span()) == expected;
}

}  // namespace

SWIFTGS_CASE_ON("backend: exclusive_scan replaces each count by the sum before it and returns the total",
                SWIFTGS_TEST_FUNCTOR_BACKENDS) {
  for (const std::size_t n : {0, 1, 2, 31, 32, 33, 1000, 32'767, 32'768, 300'001, 1'000'000}) {
    CAPTURE(n);
    Random random(n);
    std::vector<std::uint32_t> counts(n);
    for (std::uint32_t& count : counts) count = std::uint32_t(random.bits() % 100);
    CHECK(scans(backend, counts));
  }
  // Totals may have more than 32 bits.
  CHECK(scans(backend, std::vector<std::uint32_t>(100'000, 0xffffffffu)));
  CHECK(scans(backend, {0x80000000u, 0x80000000u}));
  CHECK(scans(backend, {0xffffffffu}));
}

SWIFTGS_CONTRACT("backend: sort_pairs is a stable sort by the low bits alone") {
  for (const std::size_t n : {0, 1, 2, 3, 257, 30'001}) {
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
  // Equal keys keep their order.
  CHECK(sorts(backend, std::vector<std::uint32_t>(300'000, 0xdeadbeefu), 31));
  CHECK(sorts(backend, std::vector<std::uint64_t>(100'001, 0xdeadbeef12345678u), 44));
  CHECK(sorts(backend, random_keys<std::uint32_t>(300'000, 3), 13));
  CHECK(sorts(backend, random_keys<std::uint64_t>(300'000, 4), 44));
}

SWIFTGS_CONTRACT("backend: sort_pairs sorts by every digit when only one digit differs") {
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
    CHECK(scans(backend, std::vector<std::uint32_t>(200'000, 3)));
  }
}

TEST_CASE("cpu: a negative number of threads is refused") {
  for (const int threads : {-1, -2, std::numeric_limits<int>::min()}) {
    CAPTURE(threads);
    const std::string said =
        "backend: threads is " + std::to_string(threads) + ", expected 1 or more, or 0 for all";
    CHECK_THROWS_WITH_AS(Cpu{threads}, said.c_str(), std::invalid_argument);
    CHECK_THROWS_WITH_AS(make_backend(std::type_identity<Cpu>(), {.threads = threads}), said.c_str(),
                         std::invalid_argument);
  }
  CHECK(Cpu(0).threads() >= 1);
}

SWIFTGS_CASE_ON("backend: an uploaded scene is shared and seen as it is", SWIFTGS_TEST_HOSTS) {
  const auto scene = std::make_shared<const Scene>(random_scene(10, 2, 6));
  const SceneView view = backend.upload(scene).view();
  CHECK(view.means.data == scene->means.data());
  CHECK(view.size() == 10);
  CHECK(view.sh_degree == 2);
  CHECK(view.sh_rest.stride == 24 * sizeof(float));
}

SWIFTGS_CONTRACT("backend: an upload refuses a scene that is broken and names the Gaussian") {
  CHECK_THROWS_AS((void)backend.upload(std::shared_ptr<const Scene>()), std::invalid_argument);
  struct Broken {
    const char* message;
    void (*spoil)(Scene&);
  };
  const Broken all[] = {
      {"scene: opacities has 39 elements, expected 40", [](Scene& s) { s.opacities.pop_back(); }},
      {"scene: means of Gaussian 7 is nan, expected finite numbers", [](Scene& s) { s.means[7].y = NAN; }},
      {"scene: scales of Gaussian 0 is inf, expected finite numbers",
       [](Scene& s) { s.scales[0].z = INFINITY; }},
      {"scene: rotations of Gaussian 39 is -inf, expected finite numbers",
       [](Scene& s) { s.rotations[39].w = -INFINITY; }},
      {"scene: opacities of Gaussian 3 is inf, expected finite numbers",
       [](Scene& s) { s.opacities[3] = INFINITY; }},
      {"scene: sh0 of Gaussian 4 is nan, expected finite numbers", [](Scene& s) { s.sh0[4].x = NAN; }},
      {"scene: sh_rest of Gaussian 11 is nan, expected finite numbers",
       [](Scene& s) { s.sh_rest[24 * 11 + 23] = NAN; }}};
  for (const Broken& broken : all) {
    Scene scene = random_scene(40, 2, 1);
    CHECK_NOTHROW((void)backend.upload(scene));
    broken.spoil(scene);
    CHECK_THROWS_WITH_AS((void)backend.upload(scene), broken.message, std::invalid_argument);
  }
}

SWIFTGS_CASE_ON("backend: its clock runs forwards and is read without waiting", SWIFTGS_TEST_HOSTS) {
  const auto from = backend.now();
  const std::optional<double> ms = backend.milliseconds(from, backend.now());
  REQUIRE(ms);
  CHECK(*ms >= 0);
  CHECK(*ms < 60'000);
}

SWIFTGS_CONTRACT("backend: a buffer grows and never shrinks and is aligned to a cache line") {
  typename B::template Buffer<float> buffer;
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

}  // namespace swiftgs::test::backend_test
