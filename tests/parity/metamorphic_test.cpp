// SPDX-License-Identifier: Apache-2.0
#include <string_view>

namespace swiftgs::test {
namespace {
constexpr std::string_view backends[] = {"serial", "cpu"};
bool unavailable() { return false; }
}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_METAMORPHIC "metamorphic"
#include "parity/metamorphic_cases.hpp"
