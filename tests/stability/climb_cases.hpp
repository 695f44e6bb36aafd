// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A short search with fixed seeds on whatever backend the including file has.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include <doctest/doctest.h>

#include "hard_frames/search.hpp"
#include "stability/sweep.hpp"

namespace swiftgs::test {

template <class R, class Draw>
StressSubject subject_of() {
  const auto renderer = std::make_shared<R>();
  return {std::string(R::name), [renderer](const StressCase& drawn) { return Draw()(*renderer, drawn); }};
}

/// Whether no frame that a search draws on backend `B` is worse than the gate. It starts from lone Gaussians:
/// the sweep draws the other families.
template <class B, class Draw>
void check_climb(std::uint64_t tries) {
  using Usual = AxisSharedThreshold<FloatCholesky>;
  StressSearch search({subject_of<Renderer<B, EarlySort, Usual, Ellipse>, Draw>(),
                       subject_of<Renderer<B, StandardSort, Usual, Ellipse>, Draw>(),
                       subject_of<Renderer<B, EarlySort, AxisShared<FloatSplit>, Ellipse>, Draw>(),
                       subject_of<Renderer<B, EarlySort, PerPixel, OpacityBox>, Draw>()},
                      stress::lone_families(), 1);
  search.run(tries);
  for (std::size_t i = 0; i < search.subjects().size(); ++i)
    for (std::size_t family = 0; family < search.families().size(); ++family)
      for (const StressSearch::Plane plane : {StressSearch::colour, StressSearch::depth}) {
        const StressFind& worst = search.worst(i, plane, family);
        CAPTURE(search.subjects()[i].name);
        CAPTURE(search.families()[family].name);
        CAPTURE(plane);
        CHECK(worst.error == "");
        CHECK(worst.normalised_error <= normalised_error_gate);
      }
}

}  // namespace swiftgs::test
