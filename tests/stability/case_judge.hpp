// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The reference of one hard frame. Compiled apart from what renders: a defect that is injected into a
/// renderer cannot reach it.

#include <string_view>

#include <swiftgs/frame.hpp>
#include <swiftgs/stress.hpp>

#include "hard_frames/case.hpp"

namespace swiftgs::test {

/// Judges frames of one case.
class CaseJudge {
 public:
  explicit CaseJudge(StressCase drawn);

  const StressCase& drawn() const { return drawn_; }

  /// Judges what the renderer called `name` drew.
  StressVerdict judge(std::string_view name, const Frame& frame) const;

 private:
  StressCase drawn_;
  ConditionedFrame reference_;
};

}  // namespace swiftgs::test
