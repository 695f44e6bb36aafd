// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <sys/resource.h>

#include <swiftgs/cpu.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/swiftgs.hpp>
#include <swiftgs/tools/split_mix.hpp>

#include "pages/pools.hpp"

namespace swiftgs::test::pool_of_pages {
namespace {

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

/// How often the system has had this thread wait: for a lock, a file or a time.
long waits() {
  rusage usage{};
  REQUIRE(::getrusage(RUSAGE_THREAD, &usage) == 0);
  return usage.ru_nvcsw;
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
  const long before = waits();
  for (int i = 0; i < 100; ++i) cut = pool.cut(all_of(views), {.pixels = 0});  // hangs here if one waits
  CHECK(waits() == before);
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

}  // namespace
}  // namespace swiftgs::test::pool_of_pages
