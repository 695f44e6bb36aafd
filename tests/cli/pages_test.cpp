// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include <doctest/doctest.h>

#include "cli/command.hpp"

namespace swiftgs::test::pages_test {

TEST_CASE("cli pages: writes a page file and says what it holds") {
  const TemporaryFolder place;
  CHECK(run(place, "pages builtin:5000 a.sgp --page 256 --order")
            .out.starts_with("a.sgp: 5000 Gaussians in 20 pages, and 19 above them, "));
  CHECK(content_of(place / "a.sgp").starts_with("SGPAGES\n"));
  run(place, "convert builtin:700 b.ply");
  CHECK(run(place, "pages b.ply b.ply b.sgp --model antialiased=yes")
            .out.starts_with("b.sgp: 1400 Gaussians in 1 pages, and 0 above them, "));
  CHECK_FALSE(std::filesystem::exists(place / "a.sgp.building"));
}

TEST_CASE("cli pages: refuses what cannot be built in one line") {
  const TemporaryFolder place;
  fails(place, "pages a.sgp", {"pages: expected one or more scenes to read and a file to write"});
  fails(place, "pages builtin:500 a.sgp --page 100", {"a page of 100 Gaussians, expected a multiple of 128"});
  fails(place, "pages builtin:500 a.sgp --memory 1", {"1048576 bytes of memory, expected "});
  fails(place, "pages builtin:500 builtin:500 a.sgp", {"builtin:500: expected files"});
  fails(place, "pages none.ply a.sgp", {"none.ply"});
  CHECK_FALSE(std::filesystem::exists(place / "a.sgp"));
  CHECK_FALSE(std::filesystem::exists(place / "a.sgp.building"));
}

}  // namespace swiftgs::test::pages_test
