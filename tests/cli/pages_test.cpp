// SPDX-License-Identifier: Apache-2.0
#include <filesystem>

#include <doctest/doctest.h>

#include "cli/cameras.hpp"
#include "cli/command.hpp"
#include "cli/json_in.hpp"

namespace swiftgs::test::pages_test {

TEST_CASE("cli pages: writes a page file and says what it holds") {
  const TemporaryFolder place;
  CHECK(run(place, "pages builtin:5000 a.sgp --page 256 --order")
            .out.starts_with("a.sgp: 5000 Gaussians in 20 pages, and 19 above them, "));
  CHECK(content_of(place / "a.sgp").starts_with("SGPAGES\n"));
  run(place, "convert builtin:700 b.ply");
  CHECK(run(place, "pages b.ply b.ply b.sgp --model antialiased=yes")
            .out.starts_with("b.sgp: 1400 Gaussians in 1 pages, and 0 above them, "));
}

TEST_CASE("cli pages: render draws the bits of the scene at 0 pixels and info counts its pages") {
  const TemporaryFolder place;
  run(place, "convert builtin:3000 a.ply");
  run(place, "pages a.ply a.sgp --page 256");
  check_holds(run(place, "info a.sgp").out,
              {"format          page file\n", "pages           12, and 11 above them"});
  check_members(json::parse(run(place, "info a.sgp --json -").out), R"({"gaussians": 3000, "sh_degree": 3})");
  place.write("cameras.json", cameras_json({"v.png"}));
  const std::string views = " --format pfm --cameras cameras.json --out ";
  run(place, "render a.ply" + views + "plain");
  CHECK(contains(run(place, "render a.sgp --pixels 0" + views + "paged").out,
                 "with errors of 0 pixels at most"));
  CHECK(content_of(place / "paged/v.pfm") == content_of(place / "plain/v.pfm"));
  CHECK(contains(run(place, "render a.sgp --pixels 20 --estimate 64" + views + "coarse").out,
                 "pages: frames are estimated to be "));
  CHECK(content_of(place / "coarse/v.pfm") != content_of(place / "plain/v.pfm"));
  run(place, "render a.sgp a.ply --place" + views + "both");
}

TEST_CASE("cli pages: other commands take pages as whole scenes and pages of pages have all Gaussians") {
  const TemporaryFolder place;
  run(place, "convert builtin:700 a.ply");
  run(place, "pages a.ply a.sgp --page 256");
  run(place, "convert a.sgp b.ply"), run(place, "convert a.ply c.ply");
  CHECK(content_of(place / "b.ply") == content_of(place / "c.ply"));
  CHECK(run(place, "pages a.sgp a.ply b.sgp")
            .out.starts_with("b.sgp: 1400 Gaussians in 1 pages, and 0 above them, "));
}

TEST_CASE("cli pages: refuses what cannot be built in one line") {
  const TemporaryFolder place;
  fails(place, "pages a.sgp", {"pages: expected one or more scenes to read and a file to write"});
  fails(place, "pages builtin:500 a.sgp --page 100", {"a page of 100 Gaussians, expected a multiple of 128"});
  fails(place, "pages builtin:500 a.sgp --memory 1", {"1048576 bytes of memory, expected "});
  fails(place, "pages builtin:500 builtin:500 a.sgp", {"builtin:500: expected files"});
  fails(place, "pages none.ply a.sgp", {"none.ply"});
  fails(place, "pages builtin:500 /dev/null", {"/dev/null: expected a file, found a pipe or a device"});
  run(place, "pages builtin:500 b.sgp");
  fails(place, "render b.sgp --renderer reference", {"expected another renderer for pages"});
  fails(place, "render b.sgp --pool 0", {"--pool: expected megabytes above 0"});
  fails(place, "render b.sgp --estimate -1", {"--estimate: expected megabytes of 0 or more"});
  fails(place, "render b.sgp --estimate 0.001", {"estimate: 1000 bytes, expected ", " for the roots"});
  fails(place, "render b.sgp builtin:500 --place --estimate 64", {"--estimate: a scene without pages"});
  fails(place, "render b.sgp --model blur=0", {"--model blur=0: expected none for pages"});
  CHECK_FALSE(std::filesystem::exists(place / "a.sgp"));
}

}  // namespace swiftgs::test::pages_test
