// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/version.hpp>

TEST_CASE("version: the string is composed of the numbers") {
  using namespace swiftgs;
  CHECK(version == std::to_string(version_major) + "." + std::to_string(version_minor) + "." +
                       std::to_string(version_patch));
}
