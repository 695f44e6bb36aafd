// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/swiftgs.hpp>
#include <swiftgs/tools/split_mix.hpp>

#include "pages/scenes.hpp"

namespace swiftgs::test::pool_of_pages {
namespace {

constexpr int width = 160, height = 96;

View view_of(const Camera& camera) {
  return make_view(camera, Conventions::gsplat(), {.width = width, .height = height});
}
std::vector<View> front() { return {view_of(builtin_camera(width, height))}; }
Span<const View> all_of(const std::vector<View>& views) { return {views.data(), views.size()}; }

/// Bytes of a file in memory that a test holds up and breaks.
struct TestSource {
  std::string content;
  std::function<void()> before_read = [] {};

  static std::shared_ptr<TestSource> of(const Scene& scene) {
    const TemporaryFolder folder;
    build_pages(scene, folder / "a.sgp", small_pages());
    auto source = std::make_shared<TestSource>();
    source->content = content_of(folder / "a.sgp");
    return source;
  }
};
PagedScene open(const std::shared_ptr<TestSource>& source) {
  return PagedScene(
      [source](std::uint64_t offset, std::span<std::byte> to) {
        source->before_read();
        std::memcpy(to.data(), source->content.data() + offset, to.size());
      },
      source->content.size(), "test.sgp");
}

/// Leaves below a page.
void leaves_below(const PagedScene& pages, std::uint32_t page, std::vector<std::uint32_t>& leaves) {
  const Span<const Page> all = pages.pages();
  const Page& row = all[page];
  if (row.is_leaf()) return leaves.push_back(page);
  leaves_below(pages, row.left, leaves), leaves_below(pages, row.right, leaves);
}

/// Whether each leaf that some view may show stands in the cut once, itself or by a page above it; and no
/// page of the cut shows nothing.
void check_no_hole(const Cut& cut, const PagedScene& pages, const std::vector<View>& views) {
  std::vector<std::uint32_t> drawn;
  std::uint32_t first = 0;
  for (const PlacedScene& placed : cut.scenes()) {
    leaves_below(pages, cut.named(first).page, drawn);
    first += std::uint32_t(placed.size());
  }
  const std::set<std::uint32_t> once(drawn.begin(), drawn.end());
  CHECK(once.size() == drawn.size());
  for (const View& view : views)
    for (std::uint32_t i = 0; i < pages.pages().size; ++i)
      if (pages.pages()[i].is_leaf() && !ChunkCuller(view.camera).hides(pages.pages()[i].bounds))
        CHECK(once.contains(i));
}

template <class B, class Sort, class Raster, class Bounds>
void check_goal_0(const Scene& scene, const PagedScene& pages) {
  Renderer<B, Sort, Raster, Bounds> renderer;
  PagePool<B> pool(renderer.backend(), pages);
  const Camera camera = builtin_camera(width, height);
  const std::vector<View> views = front();
  Cut cut = pool.cut(all_of(views), {.pixels = 0});
  pool.wait(cut);
  CHECK(cut.missing() == 0);
  CHECK(cut.pixels() == 0);
  const auto whole = renderer.backend().upload(scene);
  INFO(std::string(renderer.name));
  CHECK(renderer.render(cut.scenes(), camera).colour == renderer.render(whole, camera).colour);
}

TEST_CASE_TEMPLATE("pages: a complete cut of goal 0 has the bits of the scene", B, Serial, Cpu) {
  const TemporaryFolder folder;
  const Scene scene = ordered_scene(6000);
  const PagedScene pages = pages_of(folder, scene);
  using Raster = AxisSharedThreshold<FloatCholesky>;
  for_each_type(AllSorts(),
                [&](auto sort) { check_goal_0<B, decltype(sort), Raster, Ellipse>(scene, pages); });
  for_each_type(AllBounds(),
                [&](auto bounds) { check_goal_0<B, EarlySort, Raster, decltype(bounds)>(scene, pages); });
}

TEST_CASE("pages: goal 0 draws leaves where all Gaussians lie in one place") {
  const TemporaryFolder folder;
  Scene scene = make_builtin_scene(2000);
  std::fill(scene.means.begin(), scene.means.end(), vec3(0, -0.5f, 0));
  const PagedScene pages = pages_of(folder, scene);
  Renderer<Serial> renderer;
  PagePool<Serial> pool(renderer.backend(), pages);
  const std::vector<View> views = front();
  Cut cut = pool.cut(all_of(views), {.pixels = 0});
  pool.wait(cut);
  CHECK(cut.splats() == 2000);
  CHECK(cut.named(0).is_gaussian);
}

TEST_CASE("pages: a source that throws without a text shows the parent") {
  const auto source = TestSource::of(ordered_scene(2000));
  const PagedScene pages = open(source);
  Renderer<Serial> renderer;
  PagePool<Serial> pool(renderer.backend(), pages);
  source->before_read = [] { throw std::runtime_error(""); };
  const std::vector<View> views = front();
  Cut cut = pool.cut(all_of(views), {.pixels = 0});
  pool.wait(cut);
  REQUIRE_FALSE(cut.failed().empty());
  CHECK(cut.failed()[0].reason == "a source threw an exception without a text");
  check_no_hole(cut, pages, views);
}

/// A backend whose memory ends after some pages.
struct Bounded : Serial {
  std::size_t uploads_left;

  SceneOn upload(Scene scene) {
    if (uploads_left == 0) throw std::runtime_error("no memory");
    --uploads_left;
    return Serial::upload(std::move(scene));
  }
};

TEST_CASE("pages: waiting for a cut again goes on where an upload failed") {
  Bounded backend{{}, 1};
  PagePool<Bounded> pool(backend, open(TestSource::of(ordered_scene(2000))));
  const std::vector<View> views = front();
  Cut cut = pool.cut(all_of(views), {.pixels = 0});
  CHECK_THROWS_WITH(pool.wait(cut), "no memory");
  CHECK(cut.scenes().empty());
  backend.uploads_left = 100;
  pool.wait(cut);
  CHECK(cut.is_settled());
  CHECK(cut.splats() == 2000);
}

TEST_CASE("pages: a first cut draws the root and later ones come closer to the scene") {
  const TemporaryFolder folder;
  const Scene scene = ordered_scene(20000);
  const PagedScene pages = pages_of(folder, scene);
  Renderer<Cpu> renderer;
  PagePool<Cpu> pool(renderer.backend(), pages);
  const std::vector<View> views = front();
  const Camera camera = builtin_camera(width, height);
  const Frame whole = renderer.render(renderer.backend().upload(scene), camera);
  CHECK(pool.resident() == 1);
  const Cut first = pool.cut(all_of(views), {.pixels = 0});
  REQUIRE(first.scenes().size() == 1);
  CHECK(first.splats() == pages.pages()[pages.root()].count);
  CHECK(first.missing() > 0);
  CHECK(first.late() == 0);
  CHECK_FALSE(first.named(3).is_gaussian);
  double last = psnr(renderer.render(first.scenes(), camera).colour, whole.colour);
  std::uint64_t splats = first.splats();
  for (const double pixels : {16.0, 4.0, 1.0, 0.25}) {
    Cut cut = pool.cut(all_of(views), {.pixels = pixels});
    pool.wait(cut);
    CHECK(cut.missing() == 0);
    CHECK(cut.splats() == cut.wanted());
    CHECK(cut.splats() >= splats);
    check_no_hole(cut, pages, views);
    const double db = psnr(renderer.render(cut.scenes(), camera).colour, whole.colour);
    CHECK(db > last - 0.5);
    last = db, splats = cut.splats();
  }
  CHECK(last > 30);
}

TEST_CASE("pages: budgets of splats and memory are kept and the error that they allow is told") {
  const TemporaryFolder folder;
  const PagedScene pages = pages_of(folder, ordered_scene(20000));
  Renderer<Cpu> renderer;
  const std::vector<View> views = front();
  PagePool<Cpu> roomy(renderer.backend(), pages);
  Cut cut = roomy.cut(all_of(views), {.pixels = 0, .splats = 3000});
  roomy.wait(cut);
  CHECK(cut.splats() <= 3000);
  CHECK(cut.splats() > 2000);
  CHECK(cut.pixels() > 0);
  PagePool<Cpu> tight(renderer.backend(), pages, {.bytes = 1'000'000, .ahead = 0});
  cut = tight.cut(all_of(views), {.pixels = 0});
  tight.wait(cut);
  CHECK(cut.missing() == 0);
  CHECK(cut.pixels() > 0);
  CHECK(tight.bytes() <= 1'000'000);
  CHECK(tight.bytes() > 800'000);
  check_no_hole(cut, pages, views);
  CHECK_THROWS_AS(PagePool<Cpu>(renderer.backend(), pages, {.bytes = 1000}), InvalidArgument);
  CHECK_THROWS_AS(PagePool<Cpu>(renderer.backend(), pages, {.threads = 0}), InvalidArgument);
  CHECK_THROWS_AS(PagePool<Cpu>(renderer.backend(), pages, {.ahead = -1}), InvalidArgument);
  CHECK_THROWS_AS(roomy.cut(all_of(views), {.pixels = -1}), InvalidArgument);
}

TEST_CASE("pages: views from many sides within little memory have no holes and keep the budget") {
  const PagedScene pages = open(TestSource::of(ordered_scene(20000)));
  Renderer<Cpu> renderer;
  PagePool<Cpu> pool(renderer.backend(), pages, {.bytes = 800'000, .upload_per_frame = 100'000});
  Cut shown;  // the cut before lives while the next is made, as on screens
  for (const Camera& camera : builtin_cameras(60, width, height)) {
    const std::vector<View> views{view_of(camera)};
    for (int frame = 0; frame < 3; ++frame) {
      Cut cut = pool.cut(all_of(views), {.pixels = 0.5});
      check_no_hole(cut, pages, views);
      CHECK(pool.bytes() <= 800'000);
      shown = std::move(cut);
    }
  }
}

TEST_CASE("pages: a cut never waits for a source that stands still") {
  const auto source = TestSource::of(ordered_scene(5000));
  const PagedScene pages = open(source);
  Renderer<Cpu> renderer;
  std::mutex mutex;
  std::condition_variable opened;
  bool open_gate = false;
  std::atomic<int> stopped = 0;
  PagePool<Cpu> pool(renderer.backend(), pages);  // reads the root
  source->before_read = [&] {
    ++stopped;
    std::unique_lock lock(mutex);
    opened.wait(lock, [&] { return open_gate; });
  };
  const std::vector<View> views = front();
  Cut cut;
  while (stopped == 0) cut = pool.cut(all_of(views), {.pixels = 0});
  for (int i = 0; i < 100; ++i) cut = pool.cut(all_of(views), {.pixels = 0});  // hangs here if one waits
  CHECK(stopped == 1);
  CHECK(cut.late() == cut.missing());
  CHECK(cut.scenes().size() == 1);
  check_no_hole(cut, pages, views);
  {
    const std::lock_guard lock(mutex);
    open_gate = true;
  }
  opened.notify_all();
  pool.wait(cut);
  CHECK(cut.missing() == 0);
}

TEST_CASE("pages: a source that fails and delays at random makes no hole and is told") {
  const auto source = TestSource::of(ordered_scene(15000));
  const PagedScene pages = open(source);
  Renderer<Cpu> renderer;
  for (const std::uint64_t seed : {1, 2, 3}) {
    source->before_read = [] {};
    std::vector<std::thread> threads;
    std::mutex mutex;
    {
      PagePoolOptions options{
          .bytes = 1'000'000, .upload_per_frame = 150'000, .waiting = 200'000, .threads = 3};
      if (seed != 1)
        options.executor = [&](std::function<void()> load) { threads.emplace_back(std::move(load)); };
      if (seed == 2) options.bytes = 2'000'000;  // some of which pages that wait take
      SplitMix64 random(seed);                   // which reads use until the pool is gone
      Cpu uploader;
      PagePool<Cpu> pool(renderer.backend(), pages, options, seed == 2 ? &uploader : nullptr);
      source->before_read = [&] {
        std::uint64_t bits = 0;
        {
          const std::lock_guard lock(mutex);
          bits = random.bits();
        }
        std::this_thread::sleep_for(std::chrono::microseconds(bits % 500));
        if (bits >> 62 == 0) throw std::runtime_error("no network");
      };
      std::size_t failed = 0;
      for (const Camera& camera : builtin_cameras(40, width, height)) {
        const std::vector<View> views{view_of(camera)};
        for (int frame = 0; frame < 4; ++frame) {
          const Cut cut = pool.cut(all_of(views), {.pixels = 0.5});
          check_no_hole(cut, pages, views);
          CHECK(pool.bytes() + (seed == 2 ? options.waiting : 0) <= options.bytes);
          for (const PageFailure& failure : cut.failed()) CHECK(failure.reason == "no network");
          failed += cut.failed().size();
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
      }
      CHECK(failed > 0);
      const std::vector<View> views = front();
      Cut cut = pool.cut(all_of(views), {.pixels = 0.5});
      pool.wait(cut);  // returns although some pages fail
      check_no_hole(cut, pages, views);
    }
    for (std::thread& thread : threads) thread.join();
  }
}

TEST_CASE("pages: a pool waits for an executor's jobs that read and later jobs do nothing") {
  const auto source = TestSource::of(ordered_scene(5000));
  const PagedScene pages = open(source);
  Renderer<Cpu> renderer;
  std::vector<std::function<void()>> jobs;
  std::thread reader;
  std::atomic<bool> reads = false, has_read = false;
  {
    Cpu uploader;
    PagePool<Cpu> pool(renderer.backend(), pages,
                       {.executor = [&](std::function<void()> load) { jobs.push_back(std::move(load)); }},
                       &uploader);
    source->before_read = [&] {
      reads = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      has_read = true;
    };
    pool.cut(all_of(front()), {.pixels = 0});
    REQUIRE(jobs.size() >= 2);
    reader = std::thread(jobs[0]);
    while (!reads) std::this_thread::yield();
  }
  CHECK(has_read);
  source->before_read = [] { FAIL("a job reads for a pool that is gone"); };
  jobs[1]();
  reader.join();
}

TEST_CASE("pages: the same pages in memory draw the same bits whatever came before") {
  const PagedScene pages = open(TestSource::of(ordered_scene(10000)));
  Renderer<Cpu> renderer;
  const Camera camera = builtin_camera(width, height);
  const std::vector<View> views = front();
  const auto complete = [&](PagePool<Cpu>& pool) {
    Cut cut = pool.cut(all_of(views), {.pixels = 0.5});
    pool.wait(cut);
    return renderer.render(cut.scenes(), camera).colour;
  };
  PagePool<Cpu> fresh(renderer.backend(), pages), travelled(renderer.backend(), pages);
  for (const Camera& other : builtin_cameras(8, width, height)) {
    const std::vector<View> seen{view_of(other)};
    Cut cut = travelled.cut(all_of(seen), {.pixels = 0.1});
    travelled.wait(cut);
  }
  CHECK(complete(fresh) == complete(travelled));
}

TEST_CASE("pages: copies of a file share its pages and stereo views share a cut") {
  const PagedScene pages = open(TestSource::of(ordered_scene(5000)));
  Renderer<Cpu> renderer;
  const std::vector<PlacedPages> placed{{pages}, {pages, {.translation = dvec3(30, 0, 0)}}};
  PagePool<Cpu> pool(renderer.backend(), placed);
  CHECK(pool.resident() == 1);
  std::vector<View> views;
  for (const Camera& camera : builtin_cameras(2, width, height)) views.push_back(view_of(camera));
  Cut cut = pool.cut(all_of(views), {.pixels = 0});
  pool.wait(cut);
  CHECK(pool.resident() <= pages.pages().size);
  CHECK(cut.named(0).scene == 0);
  const NamedNode last = cut.named(std::uint32_t(cut.splats() - 1));
  CHECK(last.scene == 1);
  CHECK(last.is_gaussian);
  CHECK_THROWS_AS(cut.named(std::uint32_t(cut.splats())), InvalidArgument);
  CHECK_THROWS_AS(PagePool<Cpu>(renderer.backend(), std::vector<PlacedPages>()), InvalidArgument);
}

TEST_CASE("pages: views ahead bring their pages and draw none") {
  const PagedScene pages = open(TestSource::of(ordered_scene(20000)));
  Renderer<Serial> renderer;
  PagePool<Serial> pool(renderer.backend(), pages), plain(renderer.backend(), pages);
  const std::vector<Camera> cameras = builtin_cameras(4, width, height);
  const std::vector<View> now{view_of(cameras[0])}, ahead{view_of(cameras[2])};
  Cut alone = plain.cut(all_of(now), {.pixels = 0.5}), later = plain.cut(all_of(ahead), {.pixels = 0.5});
  plain.wait(alone), plain.wait(later);
  Cut cut;
  for (int k = 0; k < 5000 && pool.resident() < plain.resident(); ++k) {
    cut = pool.cut(all_of(now), {.pixels = 0.5}, all_of(ahead));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  CHECK(pool.cut(all_of(ahead), {.pixels = 0.5}).missing() == 0);
  CHECK(cut.splats() == alone.splats());
  CHECK(cut.wanted() == alone.wanted());
}

/// A camera that walks past the scene and turns, at a frame of its walk.
Camera walker(int frame) {
  const double angle = 0.03 * frame;
  const dvec3 eye(-8 + 0.1 * frame, -1, -6);
  return look_at(eye, eye + dvec3(std::sin(angle), 0, std::cos(angle)), {0, -1, 0}, 0.8, width, height);
}

TEST_CASE("pages: cameras that go on as they do are where views ahead expect them") {
  detail::Motion motion(10), none(0);
  const std::vector<View> before{view_of(walker(5)), view_of(walker(20))},
      now{view_of(walker(6)), view_of(walker(21))};
  CHECK(motion.ahead(all_of(before)).empty());
  const std::vector<View> ahead = motion.ahead(all_of(now));
  REQUIRE(ahead.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const ViewConstants expected = view_of(walker(std::array{8, 23, 16, 31}[i])).camera;
    for (int row = 0; row < 3; ++row) {
      CHECK(ahead[i].camera.centre[row] == doctest::Approx(expected.centre[row]));
      for (int column = 0; column < 3; ++column)
        CHECK(ahead[i].camera.rotation[row][column] == doctest::Approx(expected.rotation[row][column]));
    }
  }
  CHECK(motion.ahead(all_of(now)).empty());  // they stand still
  CHECK(motion.ahead({before.data(), 1}).empty());
  none.ahead(all_of(before));
  CHECK(none.ahead(all_of(now)).empty());
}

TEST_CASE("pages: a walk finds its pages in memory where some is kept for views ahead") {
  const PagedScene pages = open(TestSource::of(ordered_scene(20000)));
  Serial backend;
  // Frames that lack a page which is read between two frames.
  const auto incomplete = [&](int ahead, std::size_t bytes) {
    PagePool<Serial> pool(backend, pages,
                          {.bytes = bytes, .ahead = ahead, .executor = [](const auto& load) { load(); }});
    int frames = 0;
    for (int frame = 0; frame < 220; ++frame) {
      const std::vector<View> views{view_of(walker(frame))};
      frames += pool.cut(all_of(views), {.pixels = 1}).missing() != 0 && frame >= 20;
    }
    return frames;
  };
  for (const std::size_t bytes : {1'500'000, 3'000'000}) {
    const int without = incomplete(0, bytes);
    CHECK(without >= 20);
    CHECK(incomplete(10, bytes) <= without / 10);
  }
}

TEST_CASE("pages: levels that blend change pictures little at a time") {
  const PagedScene pages = open(TestSource::of(ordered_scene(20000)));
  Renderer<Cpu> renderer;
  const Camera camera = builtin_camera(width, height);
  const std::vector<View> views = front();
  PagePool<Cpu> pool(renderer.backend(), pages);
  // Largest mean square change where errors grow by 2 % of the goal a frame, as if a camera came closer.
  const auto largest_change = [&](double blend, int& faded) {
    double largest = 0;
    std::vector<float> last;
    for (double pixels = 8; pixels > 2; pixels /= 1.02) {
      Cut cut = pool.cut(all_of(views), {.pixels = pixels, .blend = blend});
      pool.wait(cut);
      CHECK(cut.splats() == cut.wanted());
      for (const PlacedScene& placed : cut.scenes()) faded += placed.opacity < 1;
      std::vector<float> colour = renderer.render(cut.scenes(), camera).colour;
      if (!last.empty()) largest = std::max(largest, std::pow(10, -psnr(colour, last) / 10));
      last = std::move(colour);
    }
    return largest;
  };
  int faded = 0;
  const double at_once = largest_change(0, faded);
  CHECK(faded == 0);
  CHECK(largest_change(0.5, faded) < 0.3 * at_once);
  CHECK(faded > 100);
  CHECK_THROWS_AS(pool.cut(all_of(views), {.blend = -1}), InvalidArgument);
}

TEST_CASE("pages: pages that an older cut holds stay although others need their memory") {
  const PagedScene pages = open(TestSource::of(ordered_scene(20000)));
  Serial backend;
  PagePool<Serial> pool(backend, pages, {.bytes = 1'000'000, .ahead = 0});
  const std::vector<View> views = front(), others{view_of(builtin_cameras(2, width, height)[1])};
  Cut held = pool.cut(all_of(views), {.pixels = 0.5});
  pool.wait(held);
  const std::size_t resident = pool.resident();
  for (int frame = 0; frame < 50; ++frame) {
    const Cut cut = pool.cut(all_of(others), {.pixels = 0.5});
    check_no_hole(cut, pages, others);
    CHECK(pool.bytes() <= 1'000'000);
    CHECK(pool.resident() >= resident / 2);
  }
  CHECK(pool.cut(all_of(views), {.pixels = 0.5}).missing() == 0);
}

TEST_CASE("pages: a renderer without a named backend draws cuts and what is placed anew stays in memory") {
  const PagedScene pages = open(TestSource::of(ordered_scene(5000))),
                   others = open(TestSource::of(ordered_scene(500)));
  Renderer<Cpu> named;
  AnyRenderer& renderer = named;
  PagePool<AnyRenderer> pool(renderer, pages);
  const std::vector<View> views = front();
  const auto drawn = [&] {
    Cut cut = pool.cut(all_of(views), {.pixels = 0.5});
    pool.wait(cut);
    renderer.show({cut.scenes().data(), cut.scenes().size()});
    Frame frame;
    renderer.render(builtin_camera(width, height), {}, frame);
    return frame.colour;
  };
  Cpu uploader;
  PagePool<Cpu> same(named.backend(), pages, {}, &uploader);
  Cut cut = same.cut(all_of(views), {.pixels = 0.5});
  same.wait(cut);
  const std::vector<float> colour = drawn();
  CHECK(colour == named.render(cut.scenes(), builtin_camera(width, height)).colour);
  const std::uint64_t uploads = pool.uploads();
  CHECK(pool.resident() == uploads);
  CHECK(pool.uploaded_bytes() == pool.bytes());
  pool.place({{pages, {.translation = dvec3(0, 0, 1000)}}});
  CHECK(drawn() != colour);
  pool.place({{pages}});
  CHECK(drawn() == colour);
  CHECK(pool.uploads() == uploads);
  CHECK_THROWS_AS(pool.place({{others}}), InvalidArgument);
}

TEST_CASE("pages: numbers of a cut are those of the source whatever order leaves have") {
  const TemporaryFolder folder;
  const Scene scene = make_builtin_scene(5000);
  Renderer<Cpu> renderer;
  for (const bool order : {false, true}) {
    PageBuildOptions options = small_pages();
    options.order = order;
    PagePool<Cpu> pool(renderer.backend(), pages_of(folder, scene, options));
    const std::vector<View> views = front();
    Cut cut = pool.cut(all_of(views), {.pixels = 0});
    pool.wait(cut);
    std::uint32_t number = 0;
    for (const PlacedScene& placed : cut.scenes())
      for (std::size_t i = 0; i < placed.size(); ++i, ++number)
        CHECK(placed.scene.means[i] == scene.means[cut.named(number).number]);
  }
}

}  // namespace
}  // namespace swiftgs::test::pool_of_pages
