// SPDX-License-Identifier: Apache-2.0

// Where the memory of host backends comes from, when it is taken and when it is given back.
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/contribution.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/counted_memory.hpp"
#include "policies/random_splats.hpp"

namespace {
std::atomic<std::size_t> own_allocations{0};  // of the backends' own memory
}  // namespace

// `CacheLineMemory` and `LargePageMemory` end here. Only they align to exactly these.
void* operator new(std::size_t size, std::align_val_t alignment) {
  if (std::size_t(alignment) == 64) ++own_allocations;
  void* memory = nullptr;
  if (posix_memalign(&memory, std::size_t(alignment), size ? size : 1) != 0) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
#if !defined(__SANITIZE_ADDRESS__)  // which has its own
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++own_allocations;
  void* memory = nullptr;
  return posix_memalign(&memory, alignment, size) == 0 ? memory : nullptr;
}
#endif

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

using Usual = AxisSharedThreshold<FloatCholesky>;

template <class B>
B make(const MemoryHook& memory, int threads) {
  if constexpr (std::is_same_v<B, Cpu>)
    return Cpu(threads, memory);
  else
    return B(memory);
}

std::size_t all_of(const StageMemory& memory) { return memory.project + memory.sort + memory.raster; }

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

/// Images of views, in memory of their own.
struct Images {
  std::vector<Frame> frames;
  std::vector<View> views;

  explicit Images(const std::vector<Camera>& cameras) : frames(cameras.size()) {
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const FrameView image = prepare(frames[i], cameras[i].width, cameras[i].height, {true, true});
      std::fill(frames[i].colour.begin(), frames[i].colour.end(), -1.0f);
      views.push_back(make_view(cameras[i], Conventions::gsplat(), image, vec3(0.25f)));
    }
  }
  Span<const View> span() const { return {views.data(), views.size()}; }
  bool operator==(const Images& other) const {
    for (std::size_t i = 0; i < frames.size(); ++i)
      if (!same_bits(frames[i].colour, other.frames[i].colour) ||
          !same_bits(frames[i].alpha, other.frames[i].alpha) ||
          !same_bits(frames[i].depth, other.frames[i].depth))
        return false;
    return frames.size() == other.frames.size();
  }
  bool untouched() const {
    for (const Frame& frame : frames)
      for (const float value : frame.colour)
        if (value != -1.0f) return false;
    return true;
  }
};

/// Stereo pairs that come nearer: the first show less than the later ones.
std::vector<Camera> cameras_of(int frame, int views) {
  std::vector<Camera> cameras;
  for (int v = 0; v < views; ++v) {
    Camera camera = forward_camera(128 + 16 * v, 96, 60.0 + 40 * std::cos(0.13 * frame));
    camera.cx += 2.0 * v + 0.3 * frame;
    cameras.push_back(camera);
  }
  return cameras;
}

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

template <class B, class Sort>
struct Case {
  using Backend = B;
  using SortPolicy = Sort;
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
                   Case<Serial, StandardSort>, Case<Serial, EarlySort>, Case<Serial, AdaptiveSort>,
                   Case<Cpu, StandardSort>, Case<Cpu, EarlySort>, Case<Cpu, AdaptiveSort>) {
  using B = typename T::Backend;
  CountedMemory memory;
  const Scene scene = random_scene(3000, 1, 1);
  RenderSettings settings;
  settings.outputs = {true, true}, settings.count = true;
  const std::vector<Camera> cameras = cameras_of(0, 2);
  {
    Renderer<B, typename T::SortPolicy, Usual, Ellipse> renderer(make<B>(memory.hook(), 2));
    const auto uploaded = renderer.backend().upload(scene);
    const std::size_t before = own_allocations;
    for (int i = 0; i < 4; ++i)
      renderer.render_resident(uploaded.view(), {cameras.data(), cameras.size()}, settings);
    renderer.reserve(uploaded.view(), Images(cameras).span());
    CHECK(own_allocations == before);
    CHECK(all_of(renderer.memory()) > 100'000);
    if constexpr (std::is_same_v<B, Serial>)
      CHECK(memory.in_use() == all_of(renderer.memory()));
    else
      CHECK(memory.in_use() > all_of(renderer.memory()));  // the backend's histograms

    // It goes with the renderer.
    auto moved = std::move(renderer);
    moved.render_resident(uploaded.view(), {cameras.data(), cameras.size()}, settings);
    CHECK(own_allocations == before);
  }
  CHECK(memory.in_use() == 0);
  CHECK(memory.allocations() > 10);
  if constexpr (std::is_same_v<B, Serial>) {
    const std::size_t before = own_allocations;
    Renderer<B, EarlySort, Usual, Ellipse>().render(Serial().upload(scene), cameras[0]);
    CHECK(own_allocations > before);  // the counter counts
  }
}

TEST_CASE_TEMPLATE("memory hook: all memory of contributions comes from it and goes back", B, Serial, Cpu) {
  CountedMemory memory;
  const auto scene = std::make_shared<const Scene>(random_scene(3000, 1, 2));
  const Camera camera = forward_camera(100, 80);
  const std::size_t before = own_allocations;
  std::vector<std::uint64_t> sums;
  {
    Contributions<B> contributions(scene, make<B>(memory.hook(), 2));
    contributions.add(camera, Conventions::gsplat());
    sums = contributions.sums();
    CHECK(own_allocations == before);
    CHECK(memory.in_use() > 3000 * sizeof(std::uint64_t));
  }
  Contributions<B> expected(scene);
  expected.add(camera, Conventions::gsplat());
  CHECK(sums == expected.sums());
}

TEST_CASE_TEMPLATE("trim: gives all memory back and the next frame has the same bits", T,
                   Case<Serial, StandardSort>, Case<Serial, EarlySort>, Case<Serial, AdaptiveSort>,
                   Case<Cpu, StandardSort>, Case<Cpu, EarlySort>, Case<Cpu, AdaptiveSort>) {
  using B = typename T::Backend;
  CountedMemory memory;
  Renderer<B, typename T::SortPolicy, Usual, Ellipse> renderer(make<B>(memory.hook(), 2));
  renderer.trim();  // has nothing yet
  const auto scene = renderer.backend().upload(random_scene(3000, 1, 3));
  const std::vector<Camera> cameras = cameras_of(0, 2);
  Images expected(cameras), again(cameras), recorded(cameras);
  FrameReport report;
  for (int round = 0; round < 6; ++round) {
    Images& images = round == 0 ? expected : again;
    renderer.render_into(scene.view(), images.span(), {.count = true});
    CHECK((images == expected));
    renderer.reserve(scene.view(), recorded.span());
    renderer.record(scene.view(), &report);
    CHECK((recorded == expected));
    const Statistics statistics = renderer.statistics();
    renderer.trim();
    CHECK(memory.in_use() == 0);
    CHECK(all_of(renderer.memory()) == 0);
    CHECK(renderer.statistics().intersections == statistics.intersections);
    CHECK(renderer.statistics().raster.contributing_pairs == 0);
    CHECK(renderer.splats().view().size() == 0);
    CHECK(renderer.lists().view().ids.empty());
    CHECK_THROWS_WITH_AS(renderer.record(scene.view(), &report), "render: expected reserve before record",
                         std::invalid_argument);
    renderer.set_views(recorded.span());
    CHECK_THROWS_WITH_AS(renderer.record(scene.view(), &report), "render: expected reserve before record",
                         std::invalid_argument);
  }
  CHECK((again == expected));
}

TEST_CASE("trim: gives back the memory of a sort of the program's own") {
  CountedMemory memory;
  Renderer<Serial, PlainSort, Usual, Ellipse> renderer{Serial(memory.hook())};
  const auto scene = renderer.backend().upload(random_scene(500, 0, 4));
  const Camera camera = forward_camera(64, 48);
  const std::size_t before = own_allocations;
  const Frame expected = renderer.render(scene, camera);
  CHECK(own_allocations > before);  // its memory is the backend's own
  CHECK(all_of(renderer.memory()) > memory.in_use());
  renderer.trim();
  CHECK(all_of(renderer.memory()) == 0);
  CHECK(same_bits(renderer.render(scene, camera).colour, expected.colour));
}

TEST_CASE("trim: the adaptive sort does not count frames that take memory again") {
  const auto frames_until_decided = [](int trimmed_before) {
    Renderer<Serial, AdaptiveSort, Usual, Ellipse> renderer(Serial(), AdaptiveSort(1));
    const auto scene = renderer.backend().upload(random_scene(500, 0, 12));
    for (int frame = 0;; ++frame) {
      if (renderer.sort().calibration()) return frame;
      if (frame == trimmed_before) renderer.trim();
      renderer.render(scene, forward_camera(64, 48));
    }
  };
  CHECK(frames_until_decided(-1) == 4);  // one to warm up and one to measure, of either strategy
  CHECK(frames_until_decided(2) == 6);
}

TEST_CASE("trim: of a renderer that was chosen at run time keeps the scene") {
  std::vector<RendererEntry> table;
  append_renderers<Cpu>(table, TypeList<EarlySort>{}, TypeList<Usual>{}, TypeList<Ellipse>{});
  const std::unique_ptr<AnyRenderer> renderer = table.front().make();
  renderer->set_scene(std::make_shared<const Scene>(random_scene(500, 1, 5)));
  Frame before, after;
  renderer->render(forward_camera(64, 48), {}, before);
  CHECK(all_of(renderer->memory()) > 0);
  renderer->trim();
  CHECK(all_of(renderer->memory()) == 0);
  renderer->render(forward_camera(64, 48), {}, after);
  CHECK(same_bits(after.colour, before.colour));
}

namespace {

/// The most that any of the frames takes.
template <class R>
Capacity most_of(R& renderer, const SceneView& scene, int frames, int views) {
  Capacity most;
  for (int i = 0; i < frames; ++i) {
    Images images(cameras_of(i, views));
    renderer.render_into(scene, images.span());
    const Statistics taken = renderer.statistics();
    most.splats = std::max(most.splats, taken.visible);
    most.intersections = std::max(most.intersections, taken.intersections);
  }
  return most;
}

/// Records 50 frames of a renderer that was reserved by the first, and looks for calls of its hook.
template <class B, class Sort, class Raster, class Bounds>
void record_without_calls(int threads, std::size_t gaussians, int views, std::size_t spare) {
  CAPTURE(threads);
  CAPTURE(views);
  constexpr int frames = 50;
  CountedMemory memory, of_other;
  Renderer<B, Sort, Raster, Bounds> renderer(make<B>(memory.hook(), threads));
  Renderer<B, Sort, Raster, Bounds> other(make<B>(of_other.hook(), threads));
  const auto scene = renderer.backend().upload(random_scene(gaussians, 1, 6));
  const Capacity most = most_of(other, scene.view(), frames, views);
  Images expected(cameras_of(0, views)), images(cameras_of(0, views));
  other.render_into(scene.view(), expected.span());
  CHECK(other.statistics().intersections + 100 < most.intersections);  // later frames take more
  CHECK(other.statistics().visible < most.splats);

  renderer.reserve(scene.view(), images.span(), {most.splats + spare, most.intersections + spare});
  const std::size_t calls = memory.calls();
  for (int i = 0; i < frames; ++i) {
    CAPTURE(i);
    const std::vector<Camera> cameras = cameras_of(i, views);
    Images drawn(cameras), wanted(cameras);
    FrameReport report;
    renderer.set_views(drawn.span());
    const std::size_t own = own_allocations;
    renderer.record(scene.view(), &report);
    CHECK(own_allocations == own);
    other.render_into(scene.view(), wanted.span());
    CHECK(report.overflowed == 0);
    CHECK(report.visible == other.statistics().visible);
    CHECK(report.intersections == other.statistics().intersections);
    CHECK((drawn == wanted));
  }
  CHECK(memory.calls() == calls);
  if constexpr (std::is_same_v<Sort, AdaptiveSort>) {
    if (views != 1) return;
    // The other strategy, that a stored measurement asks for.
    const FrameView& image = images.views[0].frame;
    renderer.sort().use({{gaussians, image.width, image.height, 1.0, 2.0}});
    renderer.set_views(images.span());
    FrameReport report;
    renderer.record(scene.view(), &report);
    REQUIRE(renderer.sort().calibration());
    CHECK(!renderer.sort().calibration()->prefers_early());
    CHECK((images == expected));
    CHECK(memory.calls() == calls);
  }
}

}  // namespace

TEST_CASE_TEMPLATE("record: never calls the hook after reserve on one thread without a pool", Sort,
                   StandardSort, EarlySort, AdaptiveSort) {
  record_without_calls<Serial, Sort, Usual, Ellipse>(1, 2000, 1, 1000);
  record_without_calls<Serial, Sort, PerPixel, ThreeSigmaSquare>(1, 1000, 2, 0);
}

TEST_CASE_TEMPLATE("record: never calls the hook after reserve on one and two threads", Sort, StandardSort,
                   EarlySort, AdaptiveSort) {
  for (const int threads : {1, 2}) {
    record_without_calls<Cpu, Sort, Usual, Ellipse>(threads, 60000, 1, 0);
    record_without_calls<Cpu, Sort, Usual, OpacityBox>(threads, 30000, 2, 5000);
  }
}

TEST_CASE_TEMPLATE("record: a frame without enough capacity draws nothing and one with just enough is drawn",
                   T, Case<Serial, StandardSort>, Case<Serial, EarlySort>, Case<Cpu, StandardSort>,
                   Case<Cpu, EarlySort>) {
  using B = typename T::Backend;
  CountedMemory memory;
  Renderer<B, typename T::SortPolicy, Usual, Ellipse> renderer(make<B>(memory.hook(), 2)), other;
  const auto scene = renderer.backend().upload(random_scene(3000, 1, 7));
  for (const int views : {1, 2}) {
    const std::vector<Camera> cameras = cameras_of(24, views);
    Images expected(cameras);
    other.render_into(scene.view(), expected.span());
    const Statistics taken = other.statistics();
    const auto record = [&](Capacity capacity, bool fits) {
      Images images(cameras);
      FrameReport report{7, 7, 7};
      renderer.reserve(scene.view(), images.span(), capacity);
      const std::size_t calls = memory.calls();
      renderer.record(scene.view(), &report);
      CHECK(memory.calls() == calls);
      CHECK(report.visible == taken.visible);
      CHECK(report.overflowed == !fits);
      CHECK((fits ? images == expected : images.untouched()));
      return report;
    };
    record({taken.visible - 1, taken.intersections}, false);
    CHECK(record({taken.visible, taken.intersections - 1}, false).intersections == taken.intersections);
    CHECK(record({taken.visible, taken.intersections}, true).intersections == taken.intersections);
    record({1, 1}, false);
    CHECK(record({}, true).intersections == taken.intersections);  // measured
    CHECK(record({taken.visible, 0}, true).intersections == taken.intersections);
    CHECK(record({0, taken.intersections}, true).intersections == taken.intersections);
    // No more than can ever be shown is taken.
    const std::size_t most = std::numeric_limits<std::size_t>::max();
    record({most, taken.intersections}, true);
  }
}

TEST_CASE("record: an ordinary frame in between does not change the views that were set") {
  Renderer<Serial, EarlySort, Usual, Ellipse> renderer;
  const auto scene = renderer.backend().upload(random_scene(500, 1, 8));
  Images expected(cameras_of(3, 2)), images(cameras_of(3, 2)), others(cameras_of(9, 5));
  renderer.render_into(scene.view(), expected.span());
  renderer.reserve(scene.view(), images.span());
  renderer.render_into(scene.view(), others.span());
  FrameReport report;
  renderer.record(scene.view(), &report);
  CHECK((images == expected));
}

TEST_CASE("record: takes views of the sizes that were reserved and no others") {
  Renderer<Serial, EarlySort, Usual, Ellipse> renderer;
  const auto scene = renderer.backend().upload(random_scene(500, 1, 9));
  const auto more = renderer.backend().upload(random_scene(501, 1, 9));
  Images expected(cameras_of(3, 2)), images(cameras_of(3, 2)), one(cameras_of(3, 1)), large(cameras_of(3, 2));
  std::swap(large.views[0], large.views[1]);
  FrameReport report;
  CHECK_THROWS_AS(renderer.record(scene.view(), &report), std::invalid_argument);
  renderer.set_views(one.span());  // there is nothing yet to compare with
  renderer.reserve(scene.view(), images.span());
  CHECK_THROWS_WITH_AS(renderer.set_views(one.span()),
                       "set_views: the number of views is 1, expected 2 as reserved", std::invalid_argument);
  CHECK_THROWS_WITH_AS(
      renderer.set_views(large.span()),
      "set_views: the size or the planes of view 0 changed, expected those that were reserved",
      std::invalid_argument);
  CHECK_THROWS_WITH_AS(renderer.record(more.view(), &report),
                       "Gaussians in a recorded frame: 501 needed, the limit is 500", CapacityError);
  renderer.record(scene.view(), &report);  // the views that were set before
  renderer.render_into(scene.view(), expected.span());
  CHECK((images == expected));
  renderer.reserve(scene.view(), one.span());  // may change them
  renderer.record(scene.view(), &report);
  CHECK(!one.untouched());
}

namespace {

/// Has each allocation of `work` refused in turn. After each it must work, with memory of the same renderer.
template <class F>
std::size_t refuse_each(CountedMemory& memory, CountedMemory::Refusal by, const F& work) {
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
                   Case<Serial, StandardSort>, Case<Serial, EarlySort>, Case<Serial, AdaptiveSort>,
                   Case<Cpu, StandardSort>, Case<Cpu, EarlySort>, Case<Cpu, AdaptiveSort>) {
  using B = typename T::Backend;
  const Scene scene = random_scene(1000, 1, 10);
  const std::vector<Camera> cameras = cameras_of(5, 2);
  Images expected(cameras);
  Renderer<B, typename T::SortPolicy, Usual, Ellipse>().render_into(Serial().upload(scene).view(),
                                                                    expected.span());
  for (const auto by : {CountedMemory::Refusal::null, CountedMemory::Refusal::exception}) {
    CountedMemory memory;
    Renderer<B, typename T::SortPolicy, Usual, Ellipse> renderer(make<B>(memory.hook(), 2));
    const auto uploaded = renderer.backend().upload(scene);
    Images images(cameras);
    const auto frame = [&](bool check) {
      if (!check) renderer.trim();
      renderer.render_into(uploaded.view(), images.span(), {.count = true});
      if (check) CHECK((images == expected));
    };
    CHECK(refuse_each(memory, by, frame) > 8);

    const auto recorded = [&](bool check) {
      if (!check) renderer.trim();
      FrameReport report;
      images = Images(cameras);
      renderer.reserve(uploaded.view(), images.span());
      renderer.record(uploaded.view(), &report);
      if (check) CHECK((images == expected));
    };
    CHECK(refuse_each(memory, by, recorded) > 8);

    // A refused `reserve` leaves nothing to record.
    FrameReport report;
    renderer.trim();
    memory.refuse_after(3, by);
    CHECK_THROWS(renderer.reserve(uploaded.view(), images.span()));
    CHECK_THROWS_AS(renderer.record(uploaded.view(), &report), std::invalid_argument);
    memory.refuse_none();

    const auto resident = [&](bool check) {
      if (!check) renderer.trim();
      const auto frames = renderer.render_resident(uploaded.view(), {cameras.data(), cameras.size()}, {});
      if (check) CHECK(frames.size == 2);
    };
    CHECK(refuse_each(memory, by, resident) > 8);
  }
}

TEST_CASE_TEMPLATE("memory hook: contributions add nothing where an allocation was refused", B, Serial, Cpu) {
  const auto scene = std::make_shared<const Scene>(random_scene(1000, 1, 11));
  const Camera small = forward_camera(40, 30), large = forward_camera(160, 120);
  Contributions<B> expected(scene);
  expected.add(small, Conventions::gsplat()), expected.add(large, Conventions::gsplat());
  for (const auto by : {CountedMemory::Refusal::null, CountedMemory::Refusal::exception}) {
    CountedMemory memory;
    std::size_t refused = 0;
    for (bool done = false; !done; ++refused) {
      memory.refuse_after(refused, by);
      std::unique_ptr<Contributions<B>> contributions;
      try {
        contributions = std::make_unique<Contributions<B>>(scene, make<B>(memory.hook(), 2));
        contributions->add(small, Conventions::gsplat());
        contributions->add(large, Conventions::gsplat());
        done = true;
      } catch (const std::bad_alloc&) {
        CHECK(by == CountedMemory::Refusal::null);
      } catch (const CapacityError&) {
        CHECK(by == CountedMemory::Refusal::exception);
      }
      memory.refuse_none();
      if (!contributions) continue;
      const bool first = contributions->sums() != std::vector<std::uint64_t>(scene->size());
      if (!first) contributions->add(small, Conventions::gsplat());
      if (!done) contributions->add(large, Conventions::gsplat());
      CHECK(contributions->sums() == expected.sums());
    }
    CHECK(refused > 8);
  }
}

TEST_CASE_TEMPLATE("memory hook: one without both functions is refused", B, Serial, Cpu) {
  check_missing_functions([](const MemoryHook& hook) { (void)make<B>(hook, 2); });
  check_missing_functions(
      [](const MemoryHook& hook) { (void)make_backend(std::type_identity<B>(), {.memory = hook}); });
}

TEST_CASE_TEMPLATE("memory hook: statistics tell of the last frame that no refusal ended", B, Serial, Cpu) {
  CountedMemory memory;
  Renderer<B, EarlySort, Usual, Ellipse> renderer(make<B>(memory.hook(), 2));
  const auto few = renderer.backend().upload(random_scene(200, 1, 13));
  const auto many = renderer.backend().upload(random_scene(3000, 1, 14));
  Images images(cameras_of(5, 2));
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
