// SPDX-License-Identifier: Apache-2.0

// Where the memory of backends comes from, when it is taken and when it is given back. The hook of a device
// is a pool that works in the order of its stream: memory that is released too early is overwritten.
#include <cmath>
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

#include "policies/counted_memory.hpp"
#include "policies/rasterizers.hpp"
#if defined(SWIFTGS_TEST_CUDA)
#include "cuda/stream_pool.hpp"
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

/// A hook that counts, and backends that take memory from it.
template <class B>
struct Hooked : CountedMemory {
  B backend(int threads = 2) { return make<B>(hook(), threads); }
};
#if defined(SWIFTGS_TEST_CUDA)
template <>
Cuda make<Cuda>(const MemoryHook& memory, int) {
  return Cuda(nullptr, memory);
}

struct WithStream {
  Stream stream;
};
template <>
struct Hooked<Cuda> : WithStream, StreamPool {
  Hooked() : StreamPool(stream.get()) {}
  Cuda backend(int = 2) { return Cuda(stream.get(), hook()); }
};
#endif

std::size_t all_of(const StageMemory& memory) { return memory.project + memory.sort + memory.raster; }

/// Images of views in memory of a backend, and what was drawn there.
template <class B>
struct Images {
  std::vector<PlanesOn<B>> planes;
  std::vector<View> views;

  explicit Images(const std::vector<Camera>& cameras) {
    const B backend = test::make_backend<B>();
    for (const Camera& camera : cameras) {
      planes.emplace_back(backend, camera.width, camera.height, Outputs{true, true}, -1.0f);
      views.push_back(make_view(camera, Conventions::gsplat(), planes.back().view(), vec3(0.25f)));
    }
  }
  Span<const View> span() const { return {views.data(), views.size()}; }
  /// After all work of `backend`.
  std::vector<std::vector<float>> drawn(const B& backend) {
    std::vector<std::vector<float>> out;
    for (PlanesOn<B>& image : planes) {
      const Frame frame = image.on_host(backend);
      out.insert(out.end(), {frame.colour, frame.alpha, frame.depth});
    }
    return out;
  }
  bool untouched(const B& backend) {
    for (const std::vector<float>& plane : drawn(backend))
      for (const float value : plane)
        if (value != -1.0f) return false;
    return true;
  }
};

/// The report of a recorded frame, in memory of a backend.
template <class B>
struct Report {
  typename B::template Buffer<FrameReport> memory;

  Report() { memory.reset(1); }
  FrameReport* data() { return memory.data(); }
  FrameReport get(const B& backend) const { return to_host(backend, memory.span())[0]; }
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

/// A backend with a sort.
template <class B, class Sort>
struct Case {
  using Backend = B;
  using SortPolicy = Sort;
};
#define SWIFTGS_SORTS_ON(B) Case<B, StandardSort>, Case<B, EarlySort>, Case<B, AdaptiveSort>
#if defined(SWIFTGS_TEST_CUDA)
#define SWIFTGS_CASES SWIFTGS_SORTS_ON(Serial), SWIFTGS_SORTS_ON(Cpu), SWIFTGS_SORTS_ON(Cuda)
#else
#define SWIFTGS_CASES SWIFTGS_SORTS_ON(Serial), SWIFTGS_SORTS_ON(Cpu)
#endif

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
                   SWIFTGS_SORTS_ON(Serial), SWIFTGS_SORTS_ON(Cpu)) {
  using B = typename T::Backend;
  CountedMemory memory;
  const Scene scene = random_scene(3000, 1, 1);
  RenderSettings settings;
  settings.outputs = {true, true}, settings.count = true;
  const std::vector<Camera> cameras = cameras_of(0, 2);
  {
    Renderer<B, typename T::SortPolicy, Usual, Ellipse> renderer(make<B>(memory.hook(), 2));
    const auto uploaded = renderer.backend().upload(scene);
    const Images<B> images(cameras);
    const std::size_t before = own_allocations;
    for (int i = 0; i < 4; ++i)
      renderer.render_resident(uploaded.view(), {cameras.data(), cameras.size()}, settings);
    renderer.reserve(uploaded.view(), images.span());
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

TEST_CASE_TEMPLATE("memory hook: all memory of contributions comes from it and goes back", B,
                   SWIFTGS_TEST_BACKENDS) {
  if (unavailable_backend<B>()) return;
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
}

TEST_CASE_TEMPLATE("trim: gives all memory back and the next frame has the same bits", T, SWIFTGS_CASES) {
  using B = typename T::Backend;
  if (unavailable_backend<B>()) return;
  Hooked<B> memory;
  Renderer<B, typename T::SortPolicy, Usual, Ellipse> renderer(memory.backend()), other;
  renderer.trim();  // has nothing yet
  const auto scene = other.backend().upload(random_scene(3000, 1, 3));
  const std::vector<Camera> cameras = cameras_of(0, 2);
  Images<B> images(cameras), recorded(cameras), wanted(cameras);
  other.render_into(scene.view(), wanted.span());
  const auto expected = wanted.drawn(other.backend());
  Report<B> report;
  for (int round = 0; round < 6; ++round) {
    renderer.render_into(scene.view(), images.span(), {.count = true});
    CHECK((images.drawn(renderer.backend()) == expected));
    renderer.reserve(scene.view(), recorded.span());
    renderer.record(scene.view(), report.data());
    CHECK((recorded.drawn(renderer.backend()) == expected));
    auto words = to_backend(renderer.backend(), std::vector<std::uint32_t>(100));
    CHECK(renderer.backend().exclusive_scan(words.span()) == 0);  // may take memory too
    const Statistics statistics = renderer.statistics();
    CHECK(memory.in_use() >= all_of(renderer.memory()));
    renderer.trim();
    CHECK(memory.in_use() == 0);
    CHECK(all_of(renderer.memory()) == 0);
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
template <class B>
Capacity most_of(BoundRenderer<B>& renderer, const SceneView& scene, int frames, int views) {
  Capacity most;
  for (int i = 0; i < frames; ++i) {
    Images<B> images(cameras_of(i, views));
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
  Hooked<B> memory, of_other;
  Renderer<B, Sort, Raster, Bounds> renderer(memory.backend(threads)), other(of_other.backend(threads));
  const auto scene = other.backend().upload(random_scene(gaussians, 1, 6)),
             empty = other.backend().upload(Scene());
  const Capacity most = most_of(other, scene.view(), frames, views);
  Images<B> expected(cameras_of(0, views)), images(cameras_of(0, views));
  other.render_into(scene.view(), expected.span());
  CHECK(other.statistics().intersections + 100 < most.intersections);  // later frames take more
  CHECK(other.statistics().visible < most.splats);

  Report<B> memory_of_report;
  renderer.reserve(scene.view(), images.span(), {most.splats + spare, most.intersections + spare});
  const std::size_t calls = memory.calls();
  for (int i = 0; i < frames; ++i) {
    CAPTURE(i);
    const std::vector<Camera> cameras = cameras_of(i, views);
    Images<B> drawn(cameras), wanted(cameras);
    renderer.set_views(drawn.span());
    const std::size_t own = own_allocations;
    renderer.record(scene.view(), memory_of_report.data());
    if (on_host<B>) CHECK(own_allocations == own);
    other.render_into(scene.view(), wanted.span());
    const FrameReport report = memory_of_report.get(renderer.backend());
    CHECK(report.overflowed == 0);
    CHECK(report.visible == other.statistics().visible);
    CHECK(report.intersections == other.statistics().intersections);
    CHECK((drawn.drawn(renderer.backend()) == wanted.drawn(other.backend())));
  }
  renderer.set_views(images.span());
  renderer.record(empty.view(), memory_of_report.data());
  CHECK(memory_of_report.get(renderer.backend()).visible == 0);
  CHECK(memory.calls() == calls);
  if constexpr (std::is_same_v<Sort, AdaptiveSort>) {
    if (views != 1) return;
    // The other strategy, that a stored measurement asks for.
    const FrameView& image = images.views[0].frame;
    renderer.sort().use({{gaussians, image.width, image.height, 1.0, 2.0}});
    renderer.record(scene.view(), memory_of_report.data());
    REQUIRE(renderer.sort().calibration());
    CHECK(!renderer.sort().calibration()->prefers_early());
    CHECK((images.drawn(renderer.backend()) == expected.drawn(other.backend())));
    CHECK(memory.calls() == calls);
  }
}

}  // namespace

TEST_CASE_TEMPLATE("record: never calls the hook after reserve", T, SWIFTGS_CASES) {
  using B = typename T::Backend;
  using Sort = typename T::SortPolicy;
  if (unavailable_backend<B>()) return;
  if constexpr (std::is_same_v<B, Serial>) {
    record_without_calls<B, Sort, Usual, Ellipse>(1, 2000, 1, 1000);
    record_without_calls<B, Sort, PerPixel, ThreeSigmaSquare>(1, 1000, 2, 0);
  } else {
    for (const int threads : {1, 2}) {
      record_without_calls<B, Sort, Usual, Ellipse>(threads, 40'000, 1, 10);
      record_without_calls<B, Sort, Usual, OpacityBox>(threads, 20'000, 2, 5000);
      if (!on_host<B>) break;
    }
  }
}

TEST_CASE_TEMPLATE("record: a frame without enough capacity draws nothing and one with just enough is drawn",
                   T, SWIFTGS_CASES) {
  using B = typename T::Backend;
  if (unavailable_backend<B>()) return;
  Hooked<B> memory;
  Renderer<B, typename T::SortPolicy, Usual, Ellipse> renderer(memory.backend()), other;
  const auto scene = other.backend().upload(random_scene(3000, 1, 7));
  for (const int views : {1, 2}) {
    const std::vector<Camera> cameras = cameras_of(24, views);
    Images<B> expected(cameras);
    other.render_into(scene.view(), expected.span());
    const Statistics taken = other.statistics();
    const auto record = [&](Capacity capacity, bool fits) {
      Images<B> images(cameras);
      Report<B> report;
      renderer.reserve(scene.view(), images.span(), capacity);
      const std::size_t calls = memory.calls();
      renderer.record(scene.view(), report.data());
      CHECK(memory.calls() == calls);
      const FrameReport found = report.get(renderer.backend());
      CHECK(found.visible == taken.visible);
      CHECK(found.overflowed == !fits);
      if (fits)
        CHECK((images.drawn(renderer.backend()) == expected.drawn(other.backend())));
      else
        CHECK(images.untouched(renderer.backend()));
      return found.intersections;
    };
    record({taken.visible - 1, taken.intersections}, false);
    CHECK(record({taken.visible, taken.intersections - 1}, false) == taken.intersections);
    CHECK(record({taken.visible, taken.intersections}, true) == taken.intersections);
    record({1, 1}, false);
    CHECK(record({}, true) == taken.intersections);  // measured
    if (!on_host<B>) continue;
    CHECK(record({taken.visible, 0}, true) == taken.intersections);
    CHECK(record({0, taken.intersections}, true) == taken.intersections);
    // No more than can ever be shown is taken.
    const std::size_t most = std::numeric_limits<std::size_t>::max();
    record({most, taken.intersections}, true);
  }
}

TEST_CASE("record: an ordinary frame in between does not change the views that were set") {
  Renderer<Serial, EarlySort, Usual, Ellipse> renderer;
  const auto scene = renderer.backend().upload(random_scene(500, 1, 8));
  Images<Serial> expected(cameras_of(3, 2)), images(cameras_of(3, 2)), others(cameras_of(9, 5));
  renderer.render_into(scene.view(), expected.span());
  renderer.reserve(scene.view(), images.span());
  renderer.render_into(scene.view(), others.span());
  FrameReport report;
  renderer.record(scene.view(), &report);
  CHECK((images.drawn(renderer.backend()) == expected.drawn(renderer.backend())));
}

TEST_CASE("record: takes views of the sizes that were reserved and no others") {
  Renderer<Serial, EarlySort, Usual, Ellipse> renderer;
  const auto scene = renderer.backend().upload(random_scene(500, 1, 9));
  const auto more = renderer.backend().upload(random_scene(501, 1, 9));
  Images<Serial> expected(cameras_of(3, 2)), images(cameras_of(3, 2)), one(cameras_of(3, 1)),
      large(cameras_of(3, 2));
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
  CHECK_THROWS_AS(renderer.record(scene.view(), nullptr), std::invalid_argument);
  renderer.record(scene.view(), &report);  // the views that were set before
  renderer.render_into(scene.view(), expected.span());
  CHECK((images.drawn(renderer.backend()) == expected.drawn(renderer.backend())));
  renderer.reserve(scene.view(), one.span());  // may change them
  renderer.record(scene.view(), &report);
  CHECK(!one.untouched(renderer.backend()));
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
                   SWIFTGS_CASES) {
  using B = typename T::Backend;
  if (unavailable_backend<B>()) return;
  const Scene scene = random_scene(1000, 1, 10);
  const std::vector<Camera> cameras = cameras_of(5, 2);
  Renderer<B, typename T::SortPolicy, Usual, Ellipse> other;
  const auto uploaded = other.backend().upload(scene);
  Images<B> wanted(cameras);
  other.render_into(uploaded.view(), wanted.span());
  const auto expected = wanted.drawn(other.backend());
  for (const auto by : {CountedBlocks::Refusal::null, CountedBlocks::Refusal::exception}) {
    Hooked<B> memory;
    Renderer<B, typename T::SortPolicy, Usual, Ellipse> renderer(memory.backend());
    Images<B> images(cameras);
    Report<B> report;
    const auto frame = [&](bool check) {
      if (!check) renderer.trim();
      renderer.render_into(uploaded.view(), images.span(), {.count = true});
      if (check) CHECK((images.drawn(renderer.backend()) == expected));
    };
    CHECK(refuse_each(memory, by, frame) > 8);

    const auto recorded = [&](bool check) {
      if (!check) renderer.trim();
      renderer.reserve(uploaded.view(), images.span());
      renderer.record(uploaded.view(), report.data());
      if (check) CHECK((images.drawn(renderer.backend()) == expected));
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
        const auto frames = renderer.render_resident(uploaded.view(), {cameras.data(), cameras.size()}, {});
        if (check) CHECK(frames.size == 2);
      };
      CHECK(refuse_each(memory, by, resident) > 8);
    } else {
      CHECK(refuse_each(memory, by, [&](bool) { (void)renderer.backend().upload(scene); }) >= 6);
      frame(true);
    }
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

TEST_CASE_TEMPLATE("memory hook: one without both functions is refused", B, SWIFTGS_TEST_BACKENDS) {
  check_missing_functions([](const MemoryHook& hook) { (void)make<B>(hook, 2); });
  if constexpr (on_host<B>)
    check_missing_functions(
        [](const MemoryHook& hook) { (void)make_backend(std::type_identity<B>(), {.memory = hook}); });
}

TEST_CASE_TEMPLATE("memory hook: statistics tell of the last frame that no refusal ended", B, Serial, Cpu) {
  CountedMemory memory;
  Renderer<B, EarlySort, Usual, Ellipse> renderer(make<B>(memory.hook(), 2));
  const auto few = renderer.backend().upload(random_scene(200, 1, 13));
  const auto many = renderer.backend().upload(random_scene(3000, 1, 14));
  Images<B> images(cameras_of(5, 2));
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
