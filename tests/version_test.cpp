// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/version.hpp>

TEST_CASE("version: the string is composed of the numbers") {
  using namespace swiftgs;
  CHECK(version == std::to_string(version_major) + "." + std::to_string(version_minor) + "." +
                       std::to_string(version_patch));
}

TEST_CASE("version: the preprocessor knows whether it is new enough") {
#if !SWIFTGS_VERSION_AT_LEAST(SWIFTGS_VERSION_MAJOR, SWIFTGS_VERSION_MINOR, SWIFTGS_VERSION_PATCH)
  FAIL("the version is at least itself");
#endif
  CHECK(SWIFTGS_VERSION_AT_LEAST(0, 0, 999));
  CHECK(!SWIFTGS_VERSION_AT_LEAST(SWIFTGS_VERSION_MAJOR, SWIFTGS_VERSION_MINOR, SWIFTGS_VERSION_PATCH + 1));
  CHECK(!SWIFTGS_VERSION_AT_LEAST(SWIFTGS_VERSION_MAJOR, SWIFTGS_VERSION_MINOR + 1, 0));
  CHECK(!SWIFTGS_VERSION_AT_LEAST(SWIFTGS_VERSION_MAJOR + 1, 0, 0));
}
