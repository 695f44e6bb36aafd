// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The references of one hard frame. Compiled apart from what renders: the double arithmetic takes long to
/// compile, and a defect that is injected into a renderer cannot reach it.

#include <memory>
#include <string_view>

#include <swiftgs/frame.hpp>
#include <swiftgs/stress/case.hpp>

namespace swiftgs::test {

/// As `StressVerdict`, of which this holds what the gates look at.
struct Verdict {
  double ratio = 0, depth_ratio = 0, psnr_db = 0;
};

/// Judges frames of one case. References are computed when a form of the exponent first asks for its own.
class CaseJudge {
 public:
  explicit CaseJudge(StressCase drawn);
  ~CaseJudge();
  CaseJudge(const CaseJudge&) = delete;
  CaseJudge& operator=(const CaseJudge&) = delete;

  const StressCase& drawn() const { return drawn_; }

  /// Judges what the renderer called `name` drew.
  Verdict judge(std::string_view name, const Frame& frame);

 private:
  struct References;
  StressCase drawn_;
  std::unique_ptr<References> references_;
};

}  // namespace swiftgs::test
