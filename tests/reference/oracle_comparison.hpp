// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Comparison of the reference with the oracle, value by value.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/reference.hpp>
#include <swiftgs/stress.hpp>

#include "policies/placed_list.hpp"
#include "reference/oracle.hpp"
#include "reference/oracle_scenes.hpp"

namespace swiftgs::test {

/// What is rendered by both, and what the result must be like.
struct Case {
  Scene scene;
  Camera camera = oracle_camera();
  Conventions conventions{};
  dvec3 background{0.2, 0.7, -0.1};
  std::vector<float> occluder{};
  List more{};                  ///< in the frame
  Real largest_bound = 1e-11L;  ///< of errors, in parts of the largest value
  std::size_t unsure = 0;       ///< pixels that may be set aside
  std::uint64_t visible = 20;   ///< at least
};

/// The worst of one kind of values over the pixels that are sure.
struct Worst {
  Real part_of_bound = 0, bound = 0, peak = 0;
};
inline Worst compare(const std::vector<double>& values, const std::vector<Bounded>& expected,
                     const std::vector<bool>& sure) {
  Worst worst;
  const std::size_t channels = values.size() / sure.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    worst.peak = std::max(worst.peak, std::abs(expected[i].value));
    if (!sure[i / channels]) continue;
    const Real difference = std::abs(Real(values[i]) - expected[i].value);
    const bool within = difference <= expected[i].error;  // not so where it is not a number
    const Real part = expected[i].error > 0 ? difference / expected[i].error : (within ? 0 : INFINITY);
    worst.part_of_bound = within ? std::max(worst.part_of_bound, part) : std::max(part, Real(2));
    if (!within) return worst;
    worst.bound = std::max(worst.bound, expected[i].error);
  }
  return worst;
}

inline void check_worst(const Worst& worst, const Case& c) {
  CHECK(worst.part_of_bound <= 1);
  CHECK(worst.bound <= c.largest_bound * std::max(Real(1), worst.peak));
}

inline void check_values(const ReferenceFrame& frame, const OracleFrame& expected, const Case& c) {
  REQUIRE(frame.alpha.size() == expected.alpha.size());
  for (const Worst& worst : {compare(frame.colour, expected.colour, expected.sure),
                             compare(frame.alpha, expected.alpha, expected.sure),
                             compare(frame.depth, expected.depth, expected.sure)})
    check_worst(worst, c);
}

/// Checks the planes that `ReferenceFrame` does not have.
inline void check_planes(const ReferencePlanes& planes, const OracleFrame& expected, const Case& c) {
  check_worst(compare(planes.squared_depth, expected.squared_depth, expected.sure), c);
  check_worst(compare(planes.features, expected.features, expected.sure), c);
  const std::vector<bool>& sure = expected.sure;
  // The bound of a normal that may point either way is that of no other.
  CHECK(compare(planes.normal, expected.normal, sure).part_of_bound <= 1);
  std::size_t wrong = 0, unsure = 0;
  const auto compare_pick = [&](std::size_t i, const OraclePick& pick, double depth, std::uint32_t id) {
    if (!sure[i]) return;
    unsure += !pick.sure;
    wrong +=
        pick.sure && (std::abs(Real(depth) - pick.depth.value) > pick.depth.error || id != pick.gaussian);
  };
  for (std::size_t i = 0; i < sure.size(); ++i) {
    compare_pick(i, expected.first[i], planes.first_depth[i], expected.first[i].gaussian);
    compare_pick(i, expected.median[i], planes.median_depth[i], planes.median_id[i]);
    compare_pick(i, expected.largest[i], planes.depth_of_id[i], planes.id[i]);
  }
  CHECK(wrong == 0);
  CHECK(unsure <= c.unsure);
}

/// Checks all references: the two that render, and the one that hard frames are judged by.
inline void check(Case c) {
  c.scene = with_features(std::move(c.scene), 2);
  std::vector<ReferenceScene> each{{c.scene}};
  for (Placed& p : c.more) {
    p.scene = with_features(std::move(p.scene), 2, 2);
    each.push_back({p.scene, p.pose, p.opacity, p.clip, p.tint});
  }
  const Span<const ReferenceScene> scenes{each.data(), each.size()};
  const Span<const float> occluder{c.occluder.data(), c.occluder.size()};
  const OracleFrame expected = render_oracle(scenes, c.camera, c.conventions, c.background, occluder);
  check_planes(render_reference_planes(scenes, c.camera, c.conventions, 1, occluder), expected, c);
  const ReferenceFrame frame = render_reference(scenes, c.camera, c.conventions, c.background, 1, occluder);
  check_values(frame, expected, c);
  // It takes no conventions that renderers refuse, and no depths along the ray.
  if (c.conventions.alpha_min > 0 && c.conventions.depth_at == Conventions::DepthAt::centre) {
    const bool conditioned = true;
    CAPTURE(conditioned);
    check_values(render_conditioned(scenes, c.camera, c.conventions, c.background, {}, 1, occluder).frame,
                 expected, c);
  }
  CHECK(expected.visible >= c.visible);
  CHECK(expected.unsure <= c.unsure);
  if (expected.unsure > 0) return;
  CHECK(frame.visible == expected.visible);
  CHECK(frame.contributing_pairs == expected.contributing_pairs);
  CHECK(frame.pixels_stopped == expected.pixels_stopped);
}

/// Checks the case under each preset, with and without antialiasing.
inline void check_presets(Case c) {
  for (const Conventions& preset : {Conventions::gsplat(), Conventions::inria(), Conventions::khronos()})
    for (const bool antialiased : {false, true}) {
      CAPTURE(preset.cull_at_near);
      CAPTURE(preset.alpha_max);
      CAPTURE(antialiased);
      c.conventions = preset, c.conventions.antialiased = antialiased;
      if (!c.occluder.empty()) c.conventions.order = SplatOrder::depth;
      check(c);
    }
}

}  // namespace swiftgs::test
