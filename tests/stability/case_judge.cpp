// SPDX-License-Identifier: Apache-2.0
#include "stability/case_judge.hpp"

#include <utility>

namespace swiftgs::test {

CaseJudge::CaseJudge(StressCase drawn)
    : drawn_(std::move(drawn)), reference_(render_conditioned(drawn_, {}, 1)) {}

StressVerdict CaseJudge::judge(std::string_view name, const Frame& frame) const {
  return swiftgs::judge(reference_, frame, exponent_representation_named(name));
}

}  // namespace swiftgs::test
