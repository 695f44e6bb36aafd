// SPDX-License-Identifier: Apache-2.0

// Changes of a scene that must not change a bit of its image on a device.
#include <string_view>

#include "cuda/device.hpp"

namespace swiftgs::test {
namespace {
constexpr std::string_view backends[] = {"cuda"};
bool unavailable() { return without_device(); }
}  // namespace
}  // namespace swiftgs::test

#define SWIFTGS_METAMORPHIC "cuda metamorphic"
#include "parity/metamorphic_cases.hpp"
