// SPDX-License-Identifier: Apache-2.0
#include "stability/exp2_search.hpp"

#include <cstddef>
#include <vector>

#include "stability/targets.hpp"
#include "stability/ulps.hpp"

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stability/exp2_search.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "exp2-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// `Exp2` of `count` floats, a multiple of 16.
void Exp2All(const float* HWY_RESTRICT in, std::size_t count, float* HWY_RESTRICT out) {
  const hn::CappedTag<float, 16> d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) hn::StoreU(Exp2(d, hn::LoadU(d, in + i)), d, out + i);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(Exp2All);
}

namespace test {
std::vector<Worst> search_exp2(int effort) {
  Targets targets;  // of which the first has no such function
  const auto exp2 = [&](std::size_t t, const float* in, std::size_t count, float* out) {
    targets.on(t + 1, [&](auto&) { HWY_DYNAMIC_DISPATCH(Exp2All)(in, count, out); });
  };
  std::vector<Worst> all;
  for (const auto& worst : worst_of_exp2(targets.size() - 1, exp2, effort))
    all.push_back(
        {"`Exp2`", "ulps", targets.name(all.size() + 1), worst.ulps, text("v %.9g", double(worst.at))});
  return all;
}

}  // namespace test
}  // namespace swiftgs
#endif
