// SPDX-License-Identifier: Apache-2.0
#include "stability/case_judge.hpp"

#include <map>
#include <memory>
#include <string_view>
#include <utility>

#include <swiftgs/reference/conditioning.hpp>
#include <swiftgs/stress/judge.hpp>

namespace swiftgs::test {

struct CaseJudge::References {
  std::map<ExponentForm, ConditionedFrame> of_form;
};

CaseJudge::CaseJudge(StressCase drawn)
    : drawn_(std::move(drawn)), references_(std::make_unique<References>()) {}
CaseJudge::~CaseJudge() = default;

Verdict CaseJudge::judge(std::string_view name, const Frame& frame) {
  const ExponentForm form = exponent_form_named(name);
  auto at = references_->of_form.find(form);
  if (at == references_->of_form.end())
    at = references_->of_form
             .emplace(form, render_conditioned(drawn_.scene, drawn_.camera, drawn_.conventions,
                                               dvec3(drawn_.background), form, 1, 1,
                                               {drawn_.occluder.data(), drawn_.occluder.size()}))
             .first;
  const StressVerdict verdict = swiftgs::judge(at->second, frame);
  return {verdict.ratio, verdict.depth_ratio, verdict.psnr_db};
}

}  // namespace swiftgs::test
