// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "policies/backends.hpp"
#include "policies/tile_lists.hpp"

namespace swiftgs::test::adaptive_sort_test {

namespace {

/// `Serial` with a clock that the test winds: a sort takes as long as the script says, by the width of the
/// keys of intersections, which tells the strategies apart; and its end may be reported late, as a device
/// would.
class ScriptedBackend : public Serial {
 public:
  static constexpr std::string_view name = "scripted";
  using TimePoint = double;
  static bool usable() { return true; }

  template <class Key>
  void sort_pairs(Pairs<ScriptedBackend, Key>& pairs, Count n, int bits) {
    if (sizeof(Key) == 8)
      time += standard_ms, last = 's';
    else
      time += early_ms / 2, last = 'e';  // which sorts twice
    Pairs<Serial, Key> same;
    const auto exchange = [&] {
      std::swap(pairs.keys, same.keys), std::swap(pairs.spare_keys, same.spare_keys);
      std::swap(pairs.values, same.values), std::swap(pairs.spare_values, same.spare_values);
    };
    exchange();
    Serial::sort_pairs(same, n, bits);
    exchange();
  }
  TimePoint now() {
    ++asked;
    return time;
  }
  std::optional<double> milliseconds(double from, double to) {
    ++asked;
    if (late) return std::nullopt;
    return to - from;
  }

  double time = 0, standard_ms = 2, early_ms = 1;
  bool late = false;
  int asked = 0;  ///< for points and for durations
  char last = 0;  ///< sort that ran: s or e
};
static_assert(FunctorBackend<ScriptedBackend>);

/// An adaptive sort, the frames that it is shown, and what it ran for each.
struct Session {
  explicit Session(int frames_each) : sort(frames_each) {}

  /// Builds the lists of so many frames; returns the first letter of each sort that ran.
  std::string frames(int count, int width = 64, int height = 48) {
    std::string ran;
    for (int i = 0; i < count; ++i) {
      SortInput input = splats.job(width, height);
      input.key.scene = scene, input.key.views = views;
      const Binned<ScriptedBackend, Ellipse> binned(backend, input, Ellipse{});
      SortJob job = binned.job();
      job.use = use;
      const auto intersections = std::uint32_t(job.footprints.intersections.most);
      if (device_counts) job.footprints.intersections.exact = &intersections;
      sort.build(backend, job, Ellipse{}, scratch, lists);
      ran += backend.last;
      CHECK(to_vectors(lists.view()) == brute_force_lists<Ellipse>(input));
    }
    return ran;
  }
  bool knows(double standard_ms, double early_ms) const {
    const auto known = sort.measured();
    return known && known->standard == standard_ms && known->early == early_ms;
  }

  ScriptedBackend backend;
  AdaptiveSort sort;
  AdaptiveSort::Scratch<ScriptedBackend> scratch;
  TileLists<ScriptedBackend> lists;
  SplatSet splats = random_splats(20, 64, 48, 1);
  std::uint64_t scene = 1;
  std::size_t views = 1;
  FrameUse use = FrameUse::drawn;
  bool device_counts = false;
};

void make_large(SplatSet& splats) {
  for (SplatShape& shape : splats.shapes) shape = make_splat(32, 24, 40, 40, 0, 1);
}

}  // namespace

TEST_CASE("adaptive sort: measures both sorts in turn and keeps the faster one") {
  for (const double early_ms : {1, 3}) {
    Session session(2);
    session.backend.standard_ms = 100, session.backend.early_ms = 100;
    CHECK(session.frames(2) == "se");  // the first of either does not count
    session.backend.standard_ms = 2, session.backend.early_ms = early_ms;
    CHECK(session.frames(4) == "sese");
    CHECK(session.knows(2, early_ms));
    const int asked = session.backend.asked;
    CHECK(session.frames(5) == (early_ms < 2 ? "eeeee" : "sssss"));
    CHECK(session.backend.asked == asked);
  }
}

TEST_CASE("adaptive sort: a frame for which buffers grow does not count") {
  Session session(2);
  CHECK(session.frames(3) == "ses");
  // Allocations take their time, and the standard sort seems the quicker one.
  session.backend.early_ms = 100;
  make_large(session.splats);
  CHECK(session.frames(1) == "e");
  session.backend.early_ms = 1;
  session.frames(4);
  CHECK(session.knows(2, 1));
  CHECK(session.frames(3) == "eee");
}

TEST_CASE("adaptive sort: buffers of different sizes that change places do not keep it from deciding") {
  Session session(3);
  const SplatSet few = session.splats;
  session.frames(1);
  make_large(session.splats);
  session.frames(1);
  session.splats = few;
  CHECK(session.frames(6) == "sesese");
  CHECK(session.knows(2, 1));
}

TEST_CASE("adaptive sort: a device's frame that is drawn again with more capacity does not count") {
  Session session(1);
  session.device_counts = true;
  const SplatSet few = session.splats;
  make_large(session.splats);
  CHECK(session.frames(2) == "se");
  session.splats = few, session.backend.late = true, session.backend.standard_ms = 1000;
  CHECK(session.frames(1) == "s");
  make_large(session.splats);
  session.backend.late = false, session.backend.standard_ms = 5;
  CHECK(session.frames(3) == "see");
  CHECK(session.knows(5, 1));
}

TEST_CASE("adaptive sort: never waits for a measurement and renders on without it") {
  Session session(1);
  session.backend.late = true;
  CHECK(session.frames(110).find_first_not_of("se") == std::string::npos);
  CHECK_FALSE(session.sort.measured());
  CHECK(session.backend.asked <= 2 * 110);  // it does not poll
  session.backend.late = false;
  session.frames(6);
  CHECK(session.knows(2, 1));
}

TEST_CASE("adaptive sort: decides anew when the image size or the scene changes") {
  Session session(1);
  session.frames(4);
  CHECK(session.knows(2, 1));
  CHECK(session.frames(1, 80) == "s");
  CHECK_FALSE(session.sort.measured());
  session.frames(3, 80);
  CHECK(session.sort.measured());
  session.scene = 2;
  session.frames(1, 80);
  CHECK_FALSE(session.sort.measured());
}

TEST_CASE("adaptive sort: what is being measured is dropped with a new scene") {
  Session session(1);
  session.backend.late = true, session.frames(1), session.backend.late = false;
  session.scene = 2;
  // Were it taken for the new scene's first frame, which does not count, one of these would count.
  session.backend.standard_ms = session.backend.early_ms = 1000;
  CHECK(session.frames(2) == "se");
  session.backend.standard_ms = 2, session.backend.early_ms = 1;
  CHECK(session.frames(3) == "see");
  CHECK(session.knows(2, 1));
}

TEST_CASE("adaptive sort: frames of several views are measured apart from those of one") {
  Session session(1);
  session.frames(4);
  session.views = 2;  // as tall together
  session.backend.standard_ms = 1, session.backend.early_ms = 2;
  CHECK(session.frames(6) == "sesess");
  CHECK(session.knows(1, 2));
}

TEST_CASE("adaptive sort: recorded frames are not measured and are sorted as was decided or early") {
  Session session(1);
  session.use = FrameUse::recorded;
  CHECK(session.frames(6) == "eeeeee");
  CHECK(session.backend.asked == 0);
  session.backend.standard_ms = 1, session.backend.early_ms = 2;
  session.use = FrameUse::drawn, session.frames(4);
  REQUIRE(session.knows(1, 2));
  const int asked = session.backend.asked;
  session.use = FrameUse::recorded;
  CHECK(session.frames(2) == "ss");
  session.use = FrameUse::rehearsed;  // takes the memory of both sorts
  session.scratch = {};
  session.frames(1);
  CHECK(bytes_of(session.scratch.standard) > 0);
  CHECK(bytes_of(session.scratch.early) > 0);
  CHECK(session.backend.asked == asked);
}

TEST_CASE("adaptive sort: a scene without identity is sorted early and not by what was learnt") {
  Session session(1);
  session.backend.standard_ms = 1, session.backend.early_ms = 2;
  CHECK(session.frames(5) == "seses");
  const int asked = session.backend.asked;
  session.scene = 0;
  CHECK(session.frames(8) == "eeeeeeee");
  CHECK(session.backend.asked == asked);
  CHECK_FALSE(session.sort.measured());
}

TEST_CASE_TEMPLATE("adaptive sort: a scene that lies where another one lay is not taken for it", B,
                   SWIFTGS_TEST_HOSTS) {
  Renderer<B, AdaptiveSort, PerPixel, Ellipse> renderer(make_backend<B>(), AdaptiveSort(1));
  const auto memory = std::make_shared<const Scene>(random_scene(200, 0, 1));
  const auto known_after = [&](const auto& scene) {
    renderer.render(scene, forward_camera(64, 48));
    return renderer.sort().measured().has_value();
  };
  const auto scene = renderer.backend().upload(memory), copy = scene;
  for (int i = 0; i < 4; ++i) known_after(scene);
  CHECK(known_after(copy));
  CHECK_FALSE(known_after(renderer.backend().upload(memory)));
}

}  // namespace swiftgs::test::adaptive_sort_test
