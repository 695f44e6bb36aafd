// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The reference of one hard frame. Compiled apart from what renders: the double arithmetic takes long to
/// compile, and a defect that is injected into a renderer cannot reach it.

#include <cstdint>
#include <memory>
#include <string_view>

#include <swiftgs/frame.hpp>
#include <swiftgs/stress/case.hpp>

namespace swiftgs::test {

/// As `StressVerdict`, of which this holds what the gates look at. A form that is allowed no error of its own
/// has its strict one for a normalised error.
struct Verdict {
  double normalised_error = 0, normalised_depth_error = 0, psnr_db = 0, max_abs = 0;
  double judged = 1;
  std::uint64_t flips = 0;
};

/// Judges frames of one case.
class CaseJudge {
 public:
  explicit CaseJudge(StressCase drawn);
  ~CaseJudge();
  CaseJudge(const CaseJudge&) = delete;
  CaseJudge& operator=(const CaseJudge&) = delete;

  const StressCase& drawn() const { return drawn_; }

  /// Judges what the renderer called `name` drew.
  Verdict judge(std::string_view name, const Frame& frame) const;

 private:
  struct Reference;
  StressCase drawn_;
  std::unique_ptr<const Reference> reference_;
};

}  // namespace swiftgs::test
