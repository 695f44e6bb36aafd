// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

#include <doctest/doctest.h>

#include "policies/backends.hpp"
#include "policies/tile_lists.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// `Serial` with a clock that the test winds: a sort takes as long as the script says, by the width of the
/// keys of instances, which tells the strategies apart; and its end may be reported late, as a device would.
class ScriptedBackend : public Serial {
 public:
  static constexpr std::string_view name = "scripted";
  using TimePoint = double;
  static bool usable() { return true; }

  template <class Key>
  void sort_pairs(Pairs<ScriptedBackend, Key>& pairs, Count n, int bits) {
    if (sizeof(Key) == 8)
      time += standard_ms, last = "standard";
    else
      time += early_ms / 2, last = "early";  // which sorts twice
    Pairs<Serial, Key> same;
    const auto exchange = [&] {
      std::swap(pairs.keys, same.keys), std::swap(pairs.spare_keys, same.spare_keys);
      std::swap(pairs.values, same.values), std::swap(pairs.spare_values, same.spare_values);
    };
    exchange();
    Serial::sort_pairs(same, n, bits);
    exchange();
  }
  TimePoint now() { return time; }
  std::optional<double> milliseconds(double from, double to) {
    ++times_asked;
    if (late) return std::nullopt;
    return to - from;
  }

  double time = 0, standard_ms = 2, early_ms = 1;
  bool late = false;
  int times_asked = 0;
  std::string last;
};
static_assert(BackendPolicy<ScriptedBackend>);

/// An adaptive sort, the frames that it is shown, and what it ran for each.
struct Session {
  explicit Session(AdaptiveSort s) : sort(std::move(s)) {}

  /// Builds the lists of one frame; returns the strategy that ran.
  std::string frame(int width = 64, int height = 48) {
    SortInput job = splats.job(width, height);
    job.key.scene = scene, job.key.views = views;
    build_again<Ellipse>(backend, sort, job, scratch, lists);
    correct = correct && to_vectors(lists.view()) == brute_force_lists<Ellipse>(job);
    return backend.last;
  }
  std::string frames(int count) {
    std::string ran;
    for (int i = 0; i < count; ++i) ran += frame()[0];
    return ran;
  }

  ScriptedBackend backend;
  AdaptiveSort sort;
  AdaptiveSort::Scratch<ScriptedBackend> scratch;
  TileLists<ScriptedBackend> lists;
  SplatSet splats = random_splats(20, 64, 48, 1);
  std::uint64_t scene = 1;
  std::size_t views = 1;
  bool correct = true;
};

}  // namespace

TEST_CASE("adaptive sort: measures both strategies in turn and keeps the faster one") {
  Session session(AdaptiveSort(2));
  CHECK(session.frames(6) == "sesese");
  REQUIRE(session.sort.calibration());
  CHECK(session.sort.calibration()->standard_ms == 2);
  CHECK(session.sort.calibration()->early_ms == 1);
  CHECK(session.frames(5) == "eeeee");

  Session other(AdaptiveSort(2));
  other.backend.early_ms = 3;
  CHECK(other.frames(6) == "sesese");
  CHECK(other.frames(5) == "sssss");
  CHECK(session.correct);
  CHECK(other.correct);
}

TEST_CASE("adaptive sort: a frame that its renderer discards does not count") {
  Session session(AdaptiveSort(1));
  CHECK(session.frames(2) == "se");
  session.backend.late = true, session.backend.standard_ms = 1000;
  CHECK(session.frames(1) == "s");
  session.sort.discard(session.scratch);
  session.backend.late = false, session.backend.standard_ms = 5;
  CHECK(session.frames(2) == "se");
  REQUIRE(session.sort.calibration());
  CHECK(session.sort.calibration()->standard_ms == 5);
}

TEST_CASE("adaptive sort: the first frame of either strategy does not count") {
  Session session(AdaptiveSort(1));
  session.backend.standard_ms = 100, session.backend.early_ms = 1;
  CHECK(session.frames(2) == "se");
  session.backend.standard_ms = 2, session.backend.early_ms = 3;
  CHECK(session.frames(2) == "se");
  CHECK(session.frames(3) == "sss");
  CHECK(session.sort.calibration()->standard_ms == 2);
}

TEST_CASE("adaptive sort: a frame for which buffers grow does not count") {
  Session session(AdaptiveSort(2));
  CHECK(session.frames(3) == "ses");
  // Allocations take their time, and the standard sort seems the quicker one.
  session.backend.early_ms = 100;
  for (SplatShape& shape : session.splats.shapes) shape = make_splat(32, 24, 40, 40, 0, 1);
  CHECK(session.frame() == "early");
  session.backend.early_ms = 1;
  session.frames(4);
  REQUIRE(session.sort.calibration());
  CHECK(session.sort.calibration()->early_ms == 1);
  CHECK(session.frames(3) == "eee");
  CHECK(session.correct);
}

TEST_CASE("adaptive sort: buffers of different sizes that change places do not keep it from deciding") {
  Session session(AdaptiveSort(3));
  const SplatSet few = session.splats;
  session.frame();
  for (SplatShape& shape : session.splats.shapes) shape = make_splat(32, 24, 40, 40, 0, 1);
  session.frame();
  session.splats = few;
  CHECK(session.frames(6) == "sesese");
  REQUIRE(session.sort.calibration());
  CHECK(session.sort.calibration()->early_ms == 1);
  CHECK(session.correct);
}

TEST_CASE("adaptive sort: stops asking the clock once it has decided") {
  Session session(AdaptiveSort(1));
  session.frames(4);
  REQUIRE(session.sort.calibration());
  const int asked = session.backend.times_asked;
  session.frames(10);
  CHECK(session.backend.times_asked == asked);
}

TEST_CASE("adaptive sort: never waits for a measurement and renders on without it") {
  Session session(AdaptiveSort(1));
  session.backend.late = true;
  CHECK(session.frames(10).size() == 10);
  CHECK_FALSE(session.sort.calibration());
  // One question a call before and after the sort at most: it does not poll.
  CHECK(session.backend.times_asked <= 20);
  CHECK(session.correct);
  session.backend.late = false;
  for (int i = 0; i < 6 && !session.sort.calibration(); ++i) session.frame();
  REQUIRE(session.sort.calibration());
  CHECK(session.sort.calibration()->standard_ms == 2);
  CHECK(session.sort.calibration()->early_ms == 1);
}

TEST_CASE("adaptive sort: decides anew when the image size or the scene changes") {
  Session session(AdaptiveSort(1));
  session.frames(4);
  REQUIRE(session.sort.calibration());
  CHECK(session.frame(80, 48) == "standard");
  CHECK_FALSE(session.sort.calibration());
  for (int i = 0; i < 3; ++i) session.frame(80, 48);
  REQUIRE(session.sort.calibration());
  CHECK(session.sort.calibration()->width == 80);

  session.scene = 2;
  session.frame(80, 48);
  CHECK_FALSE(session.sort.calibration());
  CHECK(session.correct);
}

TEST_CASE("adaptive sort: a measurement that is under way when the scene changes is dropped") {
  Session session(AdaptiveSort(1));
  session.backend.late = true;
  session.frame();
  session.backend.late = false;
  session.scene = 2;
  // Were it taken for the new scene's first frame, which does not count, one of these would count.
  session.backend.standard_ms = session.backend.early_ms = 1000;
  CHECK(session.frames(2) == "se");
  session.backend.standard_ms = 2, session.backend.early_ms = 1;
  session.frames(2);
  REQUIRE(session.sort.calibration());
  CHECK(session.sort.calibration()->standard_ms == 2);
  CHECK(session.sort.calibration()->early_ms == 1);
}

TEST_CASE("adaptive sort: for_views spends a fifth of the views on measuring half with each strategy") {
  Session session(AdaptiveSort::for_views(100));
  session.frames(2);  // not counted
  for (int i = 0; i < 19; ++i) session.frame();
  CHECK_FALSE(session.sort.calibration());
  session.frame();
  CHECK(session.sort.calibration());

  Session few(AdaptiveSort::for_views(3));
  few.frames(4);
  CHECK(few.sort.calibration());
}

TEST_CASE("adaptive sort: a saved measurement decides from the first frame on and is not measured again") {
  for (const bool early : {false, true}) {
    Session session(AdaptiveSort({{20, 64, 48, early ? 2.0 : 1.0, early ? 1.0 : 2.0}}));
    CHECK(session.frames(5) == (early ? "eeeee" : "sssss"));
    CHECK(session.backend.times_asked == 0);
    REQUIRE(session.sort.calibration());
    CHECK(session.sort.calibration()->standard_ms == (early ? 2 : 1));
    CHECK(session.sort.calibration()->early_ms == (early ? 1 : 2));
    CHECK(session.correct);
  }
}

TEST_CASE("adaptive sort: each image size has its own saved measurement") {
  Session session(AdaptiveSort({{20, 64, 48, 1, 2}, {20, 80, 48, 2, 1}, {20, 80, 60, 1, 2}}));
  for (int round = 0; round < 3; ++round) {
    CHECK(session.frame(64, 48) == "standard");
    CHECK(session.frame(80, 48) == "early");
    CHECK(session.sort.calibration()->early_ms == 1);
    CHECK(session.frame(80, 60) == "standard");
    CHECK(session.sort.calibration()->height == 60);
  }
  CHECK(session.backend.times_asked == 0);
  CHECK(session.correct);
}

TEST_CASE("adaptive sort: a size that was not saved is measured and leaves the saved ones as they are") {
  Session session(AdaptiveSort({{20, 80, 48, 1, 2}}, 1));
  CHECK(session.frames(6) == "seseee");
  REQUIRE(session.sort.calibration());
  CHECK(session.sort.calibration()->standard_ms == 2);
  const int asked = session.backend.times_asked;
  CHECK(session.frame(80, 48) == "standard");
  CHECK(session.backend.times_asked == asked);
}

TEST_CASE("adaptive sort: a saved measurement of another scene or size is ignored") {
  const SortCalibration others[] = {{21, 64, 48, 1, 2}, {20, 63, 48, 1, 2}, {20, 64, 49, 1, 2}};
  for (const SortCalibration& other : others) {
    Session session(AdaptiveSort({other}));
    CHECK(session.frames(8) == "sesesese");
    REQUIRE(session.sort.calibration());
    CHECK(session.sort.calibration()->standard_ms == 2);
  }
}

TEST_CASE("adaptive sort: saved measurements hold for the first scene that matches and no other") {
  Session session(AdaptiveSort({{20, 64, 48, 1, 2}, {20, 80, 48, 1, 2}}));
  const std::uint64_t first = session.scene;
  session.frame();
  CHECK(session.sort.calibration());
  session.scene = 2;
  session.frame();
  CHECK_FALSE(session.sort.calibration());
  session.frame(80, 48);
  CHECK_FALSE(session.sort.calibration());
  session.scene = first;
  session.frame(80, 48);
  CHECK(session.sort.calibration());
}

TEST_CASE("adaptive sort: a saved measurement of one view is not taken for two that are as tall together") {
  Session session(AdaptiveSort({{20, 64, 48, 1, 2}}, 1));
  session.views = 2;
  CHECK(session.frames(6) == "seseee");
  CHECK_FALSE(session.sort.calibration());
  session.views = 1;
  CHECK(session.frames(3) == "sss");
  CHECK(session.sort.calibration());
}

TEST_CASE("adaptive sort: measurements that are handed over later replace what was there") {
  Session session(AdaptiveSort(1));
  CHECK(session.frames(6) == "seseee");
  session.sort.use({{20, 64, 48, 1, 2}});
  CHECK_FALSE(session.sort.calibration());
  CHECK(session.frames(3) == "sss");
  session.sort.use({});
  CHECK(session.frames(6) == "seseee");
  CHECK(session.correct);
}

TEST_CASE("adaptive sort: what was being measured when measurements are handed over is dropped") {
  Session session(AdaptiveSort(1));
  session.backend.late = true;
  session.frame();
  session.backend.late = false;
  session.sort.use({{20, 64, 48, 1, 2}});
  CHECK(session.frames(3) == "sss");
  CHECK(session.sort.calibration()->standard_ms == 1);
}

TEST_CASE("adaptive sort: a scene without identity is sorted early and not by what was learnt or saved") {
  Session session(AdaptiveSort({{20, 64, 48, 1, 2}}, 1));
  session.scene = 0;
  CHECK(session.frames(8) == "eeeeeeee");
  CHECK(session.backend.times_asked == 0);
  CHECK_FALSE(session.sort.calibration());
  session.scene = 1;
  CHECK(session.frame() == "standard");
  CHECK(session.sort.calibration());
  session.scene = 0;
  CHECK(session.frame() == "early");
  CHECK_FALSE(session.sort.calibration());
  CHECK(session.correct);
}

TEST_CASE_TEMPLATE("adaptive sort: a scene that lies where another one lay is not taken for it", B,
                   SWIFTGS_TEST_BACKENDS) {
  Renderer<B, AdaptiveSort, PerPixel, Ellipse> renderer(make_backend<B>(), AdaptiveSort(1));
  const Camera camera = forward_camera(64, 48);
  const auto memory = std::make_shared<Scene>(random_scene(200, 0, 1));
  std::uint64_t first = 0;
  {
    const auto scene = renderer.backend().upload(std::shared_ptr<const Scene>(memory));
    first = scene.view().identity;
    for (int i = 0; i < 4; ++i) renderer.render(scene, camera);
    REQUIRE(renderer.sort().calibration());
    const auto copy = scene;
    renderer.render(copy, camera);
    CHECK(renderer.sort().calibration());
  }
  const Scene other = random_scene(200, 0, 2);
  std::copy(other.means.begin(), other.means.end(), memory->means.begin());
  const auto scene = renderer.backend().upload(std::shared_ptr<const Scene>(memory));
  CHECK(scene.view().identity > first);
  renderer.render(scene, camera);
  CHECK_FALSE(renderer.sort().calibration());
}

TEST_CASE("adaptive sort: can sort again after a frame that was refused") {
  Session session(AdaptiveSort(1));
  SplatSet flood;
  for (int i = 0; i < 129; ++i) flood.add(make_splat(0, 0, 1e6, 1e6, 0, 1), 1);
  CHECK_THROWS_AS(
      build_again<Ellipse>(session.backend, session.sort, flood.job(max_image_side, max_image_side),
                           session.scratch, session.lists),
      CapacityError);
  CHECK(session.frames(5) == "sesee");
  CHECK(session.correct);
}
