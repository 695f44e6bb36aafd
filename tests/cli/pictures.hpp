// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/io/image.hpp>

#include "cli/command.hpp"

namespace swiftgs::test {

/// Names of the images that `render` draws of `arguments` into an empty folder `drawn`.
inline std::set<std::string> names_drawn(const TemporaryFolder& place, const std::string& arguments) {
  std::filesystem::remove_all(place / "drawn");
  run(place, "render " + arguments + " --out drawn");
  return files_in(place / "drawn");
}

/// The only image that `render` draws of `arguments`, in floats.
inline Image drawn(const TemporaryFolder& place, const std::string& arguments) {
  const std::set<std::string> names = names_drawn(place, arguments + " --format pfm");
  REQUIRE(names.size() == 1);
  return read_image(place / "drawn" / *names.begin());
}

}  // namespace swiftgs::test
