// SPDX-License-Identifier: Apache-2.0

// Where the memory of backends comes from, and when it is given back.
#include <cmath>
#include <memory>
#include <new>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <swiftgs/contribution.hpp>

#include "policies/hooked.hpp"

namespace swiftgs::test::memory_hook_test {

namespace {

/// The same sort, as a program may write it: memory with `bytes` alone, and none reserved.
struct PlainSort {
  static constexpr std::string_view name = "plain";
  template <class B>
  struct Scratch {
    EarlySort::Scratch<B> early;
    std::size_t bytes() const { return bytes_of(early); }
  };
  template <class B, class Bounds>
  void build(B& b, const SortJob& job, const Bounds& bounds, Scratch<B>& scratch, TileLists<B>& lists) {
    EarlySort{}.build(b, job, bounds, scratch.early, lists);
  }
};

}  // namespace

TEST_CASE("growing buffer: gives memory back to the hook that it came from") {
  CountedMemory one, other;
  GrowingBuffer<float> a(one.hook()), b(other.hook());
  a.reset(100), b.reset(10);
  const std::size_t of_one = one.in_use(), of_other = other.in_use();
  CHECK(of_one == a.bytes());
  std::swap(a, b);
  CHECK(one.in_use() == of_one);
  CHECK(other.in_use() == of_other);
  CHECK(a.bytes() == of_other);
  a.reset(1000);
  CHECK(one.in_use() == of_one);
  CHECK(other.in_use() == a.bytes());

  GrowingBuffer<float> moved(std::move(b));
  CHECK(b.data() == nullptr);
  CHECK(b.size() == 0);
  CHECK(b.bytes() == 0);
  b.reset(5);  // from the hook that it had
  CHECK(one.in_use() == moved.bytes() + b.bytes());
  b.use(other.hook());
  CHECK(one.in_use() == moved.bytes());
  CHECK(b.capacity() == 0);
  moved.resize(20), moved.data()[19] = 7;
  moved.resize(5000);
  CHECK(moved.data()[19] == 7);
  CHECK(one.in_use() == moved.bytes());
  moved.trim();
  CHECK(one.in_use() == 0);
  CHECK(moved.span().empty());
  moved.trim();
}

TEST_CASE("growing buffer: is empty after its hook refused and grows afterwards") {
  for (const auto by : {CountedMemory::Refusal::null, CountedMemory::Refusal::exception}) {
    CountedMemory memory;
    GrowingBuffer<double> buffer(memory.hook());
    buffer.reset(10);
    memory.refuse_after(0, by);
    if (by == CountedMemory::Refusal::null)
      CHECK_THROWS_AS(buffer.reset(100), std::bad_alloc);
    else
      CHECK_THROWS_AS(buffer.reset(100), CapacityError);
    CHECK(memory.in_use() == 0);
    CHECK(buffer.size() == 0);
    CHECK(buffer.bytes() == 0);
    buffer.reset(10), buffer.data()[9] = 3;
    memory.refuse_after(0, by);
    CHECK_THROWS(buffer.resize(100));
    CHECK(buffer.size() == 10);  // kept
    CHECK(buffer.data()[9] == 3);
    CHECK_THROWS_AS(buffer.reset(std::size_t(1) << 61), std::bad_alloc);
  }
}

TEST_CASE_TEMPLATE("memory hook: all memory of a renderer comes from it and goes back", T,
                   SWIFTGS_SORTS_ON_HOSTS) {
  using B = typename T::Backend;
  CountedMemory memory;
  const Scene scene = random_scene(3000, 1, 1);
  RenderSettings settings;
  settings.outputs = {true, true}, settings.count = true;
  const std::vector<AskedView> asked = asked_of(0, 2);
  const Camera cameras[] = {asked[0].camera, asked[1].camera};
  {
    Usual<B, typename T::SortPolicy> renderer(make<B>(memory.hook()));
    const auto uploaded = renderer.backend().upload(scene);
    const PlacedViews images(B(), asked);
    const std::size_t before = own_allocations;
    for (int i = 0; i < 4; ++i) renderer.render_resident(uploaded.view(), {cameras, 2}, settings);
    renderer.reserve(uploaded.view(), images.span());
    CHECK(own_allocations == before);
    CHECK(renderer.memory().total() > 100'000);
    if constexpr (std::is_same_v<B, Serial>)
      CHECK(memory.in_use() == renderer.memory().total());
    else
      CHECK(memory.in_use() > renderer.memory().total());  // the backend's histograms

    // It goes with the renderer.
    auto moved = std::move(renderer);
    moved.render_resident(uploaded.view(), {cameras, 2}, settings);
    CHECK(own_allocations == before);
  }
  CHECK(memory.in_use() == 0);
  CHECK(memory.allocations() > 10);
  if constexpr (std::is_same_v<B, Serial>) {
    const std::size_t before = own_allocations;
    Usual<B>().render(Serial().upload(scene), cameras[0]);
    CHECK(own_allocations > before);  // the counter counts
  }
}

SWIFTGS_CONTRACT("memory hook: all memory of contributions comes from it and goes back") {
  Hooked<B> memory;
  const auto scene = std::make_shared<const Scene>(random_scene(3000, 1, 2));
  const Camera camera = forward_camera(100, 80);
  const std::size_t before = own_allocations;
  std::vector<std::uint64_t> sums;
  {
    Contributions<B> contributions(scene, memory.backend());
    contributions.add(forward_camera(60, 40), Conventions::gsplat());
    contributions.add(camera, Conventions::gsplat());
    sums = contributions.sums();
    if (on_host<B>) CHECK(own_allocations == before);
    CHECK(memory.in_use() > 3000 * sizeof(std::uint64_t));
  }
  CHECK(memory.in_use() == 0);
  Contributions<B> expected(scene);
  expected.add(forward_camera(60, 40), Conventions::gsplat());
  expected.add(camera, Conventions::gsplat());
  CHECK(sums == expected.sums());
  const auto uploaded = backend.upload(*scene);
  {
    Contributions<B> of_placed(std::vector<PlacedScene>{{uploaded.view()}, {uploaded.view(), {.scale = 2}}},
                               memory.backend());
    of_placed.add(camera, Conventions::gsplat());
    CHECK(memory.in_use() > 6000 * sizeof(std::uint64_t));
  }
  CHECK(memory.in_use() == 0);
}

TEST_CASE_TEMPLATE("trim: gives all memory back and the next frame has the same bits", T,
                   SWIFTGS_SORTS_ON_BACKENDS) {
  using B = typename T::Backend;
  if (unavailable_backend<B>()) return;
  Hooked<B> memory;
  Usual<B, typename T::SortPolicy> renderer(memory.backend()), other;
  renderer.trim();  // has nothing yet
  const auto scene = other.backend().upload(random_scene(3000, 1, 3));
  const std::vector<AskedView> asked = asked_of(0, 2);
  PlacedViews images(other.backend(), asked), recorded(other.backend(), asked);
  const auto expected = draw_together(other, scene.view(), asked);
  Report<B> report;
  for (int round = 0; round < 6; ++round) {
    renderer.render_into(scene.view(), images.span(), {.count = true});
    CHECK(differing(images.finish(renderer.backend()), expected) == 0);
    renderer.reserve(scene.view(), recorded.span());
    renderer.record(scene.view(), report.data());
    CHECK(differing(recorded.finish(renderer.backend()), expected) == 0);
    if constexpr (FunctorBackend<B>) {
      auto words = to_backend(renderer.backend(), std::vector<std::uint32_t>(100));
      CHECK(renderer.backend().exclusive_scan(words.span()) == 0);  // may take memory too
    }
    const Statistics statistics = renderer.statistics();
    CHECK(memory.in_use() >= renderer.memory().total());
    renderer.trim();
    CHECK(memory.in_use() == 0);
    CHECK(renderer.memory().total() == 0);
    CHECK(renderer.statistics().intersections == statistics.intersections);
    if constexpr (on_host<B>) {
      CHECK(renderer.statistics().raster.contributing_pairs == 0);
      CHECK(renderer.splats().view().size() == 0);
      CHECK(renderer.lists().view().ids.empty());
    }
    CHECK_THROWS_WITH_AS(renderer.record(scene.view(), report.data()),
                         "render: expected reserve before record", std::invalid_argument);
    renderer.set_views(recorded.span());
    CHECK_THROWS_AS(renderer.record(scene.view(), report.data()), std::invalid_argument);
  }
}

TEST_CASE("trim: gives back the memory of a sort of the program's own") {
  CountedMemory memory;
  Usual<Serial, PlainSort> renderer{Serial(memory.hook())};
  const auto scene = renderer.backend().upload(random_scene(500, 0, 4));
  const Camera camera = forward_camera(64, 48);
  const std::size_t before = own_allocations;
  const Frame expected = renderer.render(scene, camera);
  CHECK(own_allocations > before);  // its memory is the backend's own
  CHECK(renderer.memory().total() > memory.in_use());
  renderer.trim();
  CHECK(renderer.memory().total() == 0);
  CHECK(same_bits(renderer.render(scene, camera).colour, expected.colour));
}

TEST_CASE("trim: the adaptive sort does not count frames that take memory again") {
  const auto frames_until_decided = [](int trimmed_before) {
    Usual<Serial, AdaptiveSort> renderer(Serial(), AdaptiveSort(1));
    const auto scene = renderer.backend().upload(random_scene(500, 0, 12));
    for (int frame = 0;; ++frame) {
      if (renderer.sort().measured()) return frame;
      if (frame == trimmed_before) renderer.trim();
      renderer.render(scene, forward_camera(64, 48));
    }
  };
  CHECK(frames_until_decided(-1) == 4);  // one to warm up and one to measure, of either strategy
  CHECK(frames_until_decided(2) == 6);
}

namespace {

/// Has each allocation of `work` refused in turn. After each it must work, with memory of the same renderer.
template <class F>
std::size_t refuse_each(CountedBlocks& memory, CountedBlocks::Refusal by, const F& work) {
  for (std::size_t k = 0;; ++k) {
    CAPTURE(k);
    memory.refuse_after(k, by);
    bool refused = true;
    try {
      work(false);
      refused = false;
    } catch (const std::bad_alloc&) {
      CHECK(by == CountedMemory::Refusal::null);
    } catch (const CapacityError& error) {
      CHECK(by == CountedMemory::Refusal::exception);
      CHECK(std::string(error.what()).find("bytes of a test") == 0);
    }
    memory.refuse_none();
    work(true);
    if (!refused) return k;
  }
}

}  // namespace

TEST_CASE_TEMPLATE("memory hook: a renderer works on after any of its allocations was refused", T,
                   SWIFTGS_SORTS_ON_BACKENDS) {
  using B = typename T::Backend;
  if (unavailable_backend<B>()) return;
  const Scene scene = random_scene(1000, 1, 10);
  const std::vector<AskedView> asked = asked_of(5, 2);
  const Camera cameras[] = {asked[0].camera, asked[1].camera};
  Usual<B, typename T::SortPolicy> other;
  const auto uploaded = other.backend().upload(scene);
  const auto expected = draw_together(other, uploaded.view(), asked);
  for (const auto by : {CountedBlocks::Refusal::null, CountedBlocks::Refusal::exception}) {
    Hooked<B> memory;
    Usual<B, typename T::SortPolicy> renderer(memory.backend());
    PlacedViews images(other.backend(), asked);
    Report<B> report;
    const auto frame = [&](bool check) {
      if (!check) renderer.trim();
      renderer.render_into(uploaded.view(), images.span(), {.count = true});
      if (check) CHECK(differing(images.finish(renderer.backend()), expected) == 0);
    };
    CHECK(refuse_each(memory, by, frame) > 8);

    const auto recorded = [&](bool check) {
      if (!check) renderer.trim();
      renderer.reserve(uploaded.view(), images.span());
      renderer.record(uploaded.view(), report.data());
      if (check) CHECK(differing(images.finish(renderer.backend()), expected) == 0);
    };
    CHECK(refuse_each(memory, by, recorded) > 8);

    // A refused `reserve` leaves nothing to record.
    renderer.trim();
    memory.refuse_after(3, by);
    CHECK_THROWS(renderer.reserve(uploaded.view(), images.span()));
    CHECK_THROWS_AS(renderer.record(uploaded.view(), report.data()), std::invalid_argument);
    memory.refuse_none();

    if constexpr (on_host<B>) {
      const auto resident = [&](bool check) {
        if (!check) renderer.trim();
        const auto frames = renderer.render_resident(uploaded.view(), {cameras, 2}, {});
        if (check) CHECK(frames.size == 2);
      };
      CHECK(refuse_each(memory, by, resident) > 8);
    } else {
      CHECK(refuse_each(memory, by, [&](bool) { (void)renderer.backend().upload(scene); }) >= 6);
      frame(true);
    }
  }
}

TEST_CASE_TEMPLATE("memory hook: contributions add nothing where an allocation was refused", B,
                   SWIFTGS_TEST_HOSTS) {
  const auto scene = std::make_shared<const Scene>(random_scene(1000, 1, 11));
  const Camera cameras[] = {forward_camera(40, 30), forward_camera(160, 120)};
  Contributions<B> expected(scene);
  for (const Camera& camera : cameras) expected.add(camera, Conventions::gsplat());
  for (const auto by : {CountedMemory::Refusal::null, CountedMemory::Refusal::exception}) {
    CountedMemory memory;
    std::unique_ptr<Contributions<B>> contributions;
    std::size_t added = 0;
    const auto add = [&] {
      for (; added < 2; ++added) contributions->add(cameras[added], Conventions::gsplat());
    };
    const auto add_all = [&](bool check) {
      if (!check) {
        contributions.reset(), added = 0;
        contributions = std::make_unique<Contributions<B>>(scene, make<B>(memory.hook()));
        add();
      } else if (contributions) {
        add();
        CHECK(contributions->sums() == expected.sums());
      }
    };
    CHECK(refuse_each(memory, by, add_all) > 7);
  }
}

TEST_CASE_TEMPLATE("memory hook: one without both functions is refused", B, SWIFTGS_TEST_BACKENDS) {
  check_missing_functions([](const MemoryHook& hook) { (void)make<B>(hook, 2); });
  if constexpr (on_host<B>)
    check_missing_functions(
        [](const MemoryHook& hook) { (void)make_backend(std::type_identity<B>(), {.memory = hook}); });
}

TEST_CASE_TEMPLATE("memory hook: statistics tell of the last frame that no refusal ended", B,
                   SWIFTGS_TEST_HOSTS) {
  CountedMemory memory;
  Usual<B> renderer(make<B>(memory.hook()));
  const auto few = renderer.backend().upload(random_scene(200, 1, 13));
  const auto many = renderer.backend().upload(random_scene(3000, 1, 14));
  const PlacedViews images(B(), asked_of(5, 2));
  std::size_t k = 0;
  for (bool refused = true; refused; ++k) {
    CAPTURE(k);
    renderer.render_into(few.view(), images.span(), {.count = true, .time = true});
    const Statistics before = renderer.statistics();
    REQUIRE(before.raster.contributing_pairs > 0);
    memory.refuse_after(k, CountedMemory::Refusal::null);
    try {
      renderer.trim();
      renderer.render_into(many.view(), images.span(), {.count = true, .time = true});
      refused = false;
    } catch (const std::bad_alloc&) {
    }
    memory.refuse_none();
    const Statistics after = renderer.statistics();
    CHECK((after.gaussians == before.gaussians) == refused);
    CHECK((after.visible == before.visible) == refused);
    CHECK((after.intersections == before.intersections) == refused);
    CHECK((after.raster.contributing_pairs == 0) == refused);  // their memory may be gone
    CHECK(std::isnan(renderer.times().total) == refused);
  }
  CHECK(k > 8);
}

}  // namespace swiftgs::test::memory_hook_test
