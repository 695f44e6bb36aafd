// SPDX-License-Identifier: Apache-2.0

// Several scenes in one frame: which, and where. What placements show is asserted in tests/policies.
#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/edit/all.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/metrics.hpp>

#include "cli/cameras.hpp"
#include "cli/command.hpp"

namespace swiftgs::test::placed_test {

namespace {

/// The pixels that `render` draws of `scenes`.
std::vector<float> pixels_of(const TemporaryFolder& place, const std::string& scenes,
                             const std::string& cameras = " --cameras cameras.json") {
  run_noting(place, "render " + scenes + cameras + " --format pfm");
  return swiftgs::read_image(place / "renders" / (cameras.empty() ? "view.pfm" : "a.pfm")).pixels;
}

}  // namespace

TEST_CASE("cli placed: parts of a scene in one frame are the scene") {
  const TemporaryFolder place;
  const Scene whole = swiftgs::make_builtin_scene(3000);
  const auto range_of = [&](std::size_t first, std::size_t end) {
    return subset(whole, select(whole, [&](std::size_t i) { return i >= first && i < end; }));
  };
  write_scene(place / "whole.ply", whole);
  write_scene(place / "a.ply", range_of(0, 2000));
  std::filesystem::create_directory(place / "parts");
  write_scene(place / "parts/b.ply", range_of(2000, 3000));
  place.write("cameras.json", cameras_json({"a"}));
  place.write("parts/scenes.json", R"([{"file": "../a.ply"}, {"file": "./b.ply"}])");
  place.write("ranges.json", R"([{"file": "whole.ply", "count": 700}, {"file": "a.ply", "first": 700},
    {"file": "whole.ply", "first": 2000, "count": 1000}])");
  place.write("parts/one.json",
              "\xef\xbb\xbf"
              R"(  [{"file": "b.ply"}])");  // with a byte order mark
  const std::vector<float> expected = pixels_of(place, "whole.ply");
  CHECK(pixels_of(place, "a.ply parts/b.ply --place") == expected);
  CHECK(pixels_of(place, "parts/scenes.json") == expected);
  CHECK(pixels_of(place, "ranges.json") == expected);
  CHECK(pixels_of(place, "parts/one.json a.ply --place") == expected);
  CHECK(pixels_of(place, "a.ply") != expected);

  check_holds(run_noting(place, "render parts/scenes.json --cameras cameras.json --stats --json -").out,
              {"\"scene\":\"a+b\"", "\"gaussians\":3000"});
}

TEST_CASE("cli placed: a view that is found for the first scene goes where the scene goes") {
  const TemporaryFolder place;
  write_scene(place / "room.ply", swiftgs::make_builtin_scene(3000));
  place.write("alone.json", R"([{"file": "room.ply", "translation": [1, 2, 3], "rotation": [1, 1, 0, 0]}])");
  CHECK(swiftgs::psnr(pixels_of(place, "alone.json", ""), pixels_of(place, "room.ply", "")) > 80);
}

TEST_CASE("cli placed: what cannot be placed is named") {
  const TemporaryFolder place;
  write_scene(place / "a.ply", swiftgs::make_builtin_scene(20));
  fails(place, "render a.ply a.ply builtin:10",
        {"swiftgs: render: found 3 scenes, expected one, or --place to show all in one frame\n"});
  fails(place, "render a.ply missing.ply --place", {"swiftgs: missing.ply: No such file or directory\n"});
  place.write("lists/missing.json", R"([{"file": "b.ply"}])");
  fails(place, "render lists/missing.json", {"swiftgs: lists/b.ply: No such file or directory\n"});
  place.write("list.json", R"([{"file": "a.ply", "scale": 0}])");
  fails(place, "render list.json", {"swiftgs: list.json: byte 1: expected a finite scale above 0\n"});
  const auto refuse = [&](const std::string& what, const std::string& member, const std::string& value,
                          const std::string& message) {
    if (what != "placement" || member == "scene") return;  // a list names files
    place.write("list.json", R"([{"file": "builtin:2000", ")" + member + "\": " + value + "}]");
    fails(place, "render list.json", {"swiftgs: " + message});
  };
#define REFUSED(what, member, value, message) refuse(#what, #member, #value, message);
#include "support/refusals.inc"
#undef REFUSED
  place.write("list.json", R"([{"file": "a.ply"}])");
  fails(place, "render list.json --json a.ply",
        {"swiftgs: --json a.ply: expected another file than that of SCENE\n"});
}

}  // namespace swiftgs::test::placed_test
