// SPDX-License-Identifier: Apache-2.0
#include "hard_frames/search.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <stdexcept>
#include <string_view>

#include <doctest/doctest.h>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/swiftgs.hpp>

#include "hard_frames/families.hpp"
#include "hard_frames/lone.hpp"
#include "stability/climb_cases.hpp"

namespace swiftgs {
namespace {

template <class Raster, class Sort = EarlySort>
StressSubject subject() {
  return test::subject_of<Renderer<Serial, Sort, Raster, Ellipse>, test::DrawOnHost>();
}

/// The subject, but `change(case, frame)` spoils its frames.
template <class Change>
StressSubject spoiled(StressSubject subject, Change change) {
  return {subject.name, [subject, change](const StressCase& drawn) {
            Frame frame = subject.draw(drawn);
            change(drawn, frame);
            return frame;
          }};
}

bool same_case(const StressCase& a, const StressCase& b) {
  const auto same_gaussians = [](const Scene& c, const Scene& d) {
    return c.means == d.means && c.scales == d.scales && c.opacities == d.opacities && c.sh0 == d.sh0;
  };
  return same_gaussians(a.scene, b.scene) && a.camera.rotation == b.camera.rotation &&
         a.camera.translation == b.camera.translation && a.conventions == b.conventions;
}

}  // namespace

TEST_CASE("stress: a seed draws the same frame whatever the compiler") {
  // Sums that gcc and clang found; they would differ by far if numbers were drawn in another order.
  const std::map<std::string_view, double> expected{
      {"fisheyes", 54.704603},        {"panoramas", -43.9470721},      {"world-offsets", -74008.9114},
      {"placed-scenes", 493.488434},  {"far-millimetres", -1841.0836}, {"clipped-scenes", 0.0663849733},
      {"edge-on-disks", -5.72610372},
  };
  std::size_t found = 0;
  for (const auto* families : {&stress_families(), &stress::lone_families()})
    for (const StressFamily& family : *families) {
      const auto sum = expected.find(family.name);
      if (sum == expected.end()) continue;
      CAPTURE(family.name);
      const StressCase drawn = family.make(family.severities[1], 18, {64, 48});
      const dvec3 placed = drawn.world_from_scene.translation + drawn.camera.translation;
      double got = placed.x + 2 * placed.y;
      for (const vec3& mean : drawn.scene.means) got += double(mean.x) + 2 * double(mean.y);
      for (const Quaternion& q : drawn.scene.rotations) got += double(q.x);
      CHECK(got == doctest::Approx(sum->second).epsilon(1e-6));
      ++found;
    }
  CHECK(found == expected.size());
}

TEST_CASE("search: the same seed and number of tries find the same and another seed does not") {
  const auto search = [](std::uint64_t seed) {
    StressSearch out({subject<PerPixel>()}, search_families(), seed);
    out.run(1500);
    return out;
  };
  const StressSearch first = search(5), again = search(5), other = search(6);
  std::size_t found = 0, differing = 0;
  for (std::size_t family = 0; family < search_families().size(); ++family)
    for (const StressSearch::Plane plane : {StressSearch::colour, StressSearch::depth}) {
      const StressFind &a = first.worst(0, plane, family), &b = again.worst(0, plane, family);
      CHECK(a.normalised_error == b.normalised_error);
      CHECK(same_case(a.drawn, b.drawn));
      found += a.normalised_error > 0;
      differing += !same_case(a.drawn, other.worst(0, plane, family).drawn);
    }
  CHECK(found > search_families().size());
  CHECK(differing > search_families().size());
}

TEST_CASE("search: a renderer that throws or leaves out a number or differs between sorts is a find") {
  const auto throwing = [](const StressCase&, Frame&) { throw std::runtime_error("no memory"); };
  const auto no_number = [](const StressCase&, Frame& frame) {
    frame.depth[3] = std::numeric_limits<float>::quiet_NaN();
  };
  const auto off = [](const StressCase&, Frame& frame) {
    frame.alpha[7] = std::nextafter(frame.alpha[7], 2.0f);
  };
  StressSearch search({subject<PerPixel>(), spoiled(subject<PerPixel, StandardSort>(), off),
                       spoiled(subject<AxisShared<FloatSplit>>(), throwing),
                       spoiled(subject<AxisShared<FloatCholesky>>(), no_number)},
                      {stress_families().front()}, 1);
  search.run(8);
  const auto error = [&](std::size_t subject) {
    return search.worst(subject, StressSearch::colour, 0).error;
  };
  CHECK(error(0) == "");
  CHECK(error(1) == "the frame differs from that of serial/early/per-pixel/ellipse");
  CHECK(error(2) == "no memory");
  CHECK(error(3) == "a value is not finite");
  CHECK(std::isinf(search.worst(1, StressSearch::colour, 0).normalised_error));
  CHECK(search.worst(1, StressSearch::colour, 0).drawn.scene.size() > 0);
}

TEST_CASE("search: frames of all families lie within the limits and changed ones mostly do") {
  stress::Random random(3);
  int valid = 0, changed = 0;
  for (const StressFamily& family : stress::lone_families())
    for (const double severity : family.severities)
      for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const StressCase made = family.make(severity, seed, StressSearch::one_tile);
        CAPTURE(family.name);
        CAPTURE(severity);
        CAPTURE(seed);
        CHECK(stress::is_valid(made));
        ++changed, valid += stress::is_valid(stress::mutated(random, made));
      }
  CHECK(valid > changed / 2);
}

}  // namespace swiftgs
