// SPDX-License-Identifier: Apache-2.0
#include "stability/case_judge.hpp"

#include <memory>
#include <string_view>
#include <utility>

#include <swiftgs/stress/judge.hpp>

namespace swiftgs::test {

struct CaseJudge::Reference {
  ConditionedFrame frame;
};

CaseJudge::CaseJudge(StressCase drawn)
    : drawn_(std::move(drawn)),
      reference_(std::make_unique<Reference>(Reference{render_conditioned(drawn_, 1, 1)})) {}
CaseJudge::~CaseJudge() = default;

Verdict CaseJudge::judge(std::string_view name, const Frame& frame) const {
  const ExponentRepresentation representation = exponent_representation_named(name);
  const StressVerdict verdict = swiftgs::judge(reference_->frame, frame, representation);
  return {verdict.normalised_error, verdict.normalised_depth_error,
          verdict.psnr_db,          verdict.max_abs,
          verdict.judged,           verdict.flips};
}

}  // namespace swiftgs::test
