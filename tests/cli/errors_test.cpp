// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/command.hpp"
#include "support/skip.hpp"

namespace swiftgs::test::errors_test {

TEST_CASE("cli errors: files that are missing, foreign or cut short are named with what was expected") {
  const TemporaryFolder place;
  fails(place, "info nowhere.ply", {"nowhere.ply"});
  fails(place, "render builtin:10 --cameras nowhere.json", {"nowhere.json"});
  fails(place, "compare nowhere.png nowhere.png", {"nowhere.png"});
  fails(place, "check builtin:10 --scale 0.01 --photos nowhere", {"nowhere"});

  place.write("notes.txt", "nothing that can be rendered\n");
  fails(place, "info notes.txt", {"notes.txt: byte 0: expected"});
  fails(place, "compare notes.txt notes.txt", {"notes.txt: byte 0: expected"});
  fails(place, "render builtin:10 --cameras notes.txt", {"notes.txt", "expected"});

  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(20));
  std::filesystem::resize_file(place / "scene.ply", std::filesystem::file_size(place / "scene.ply") - 100);
  for (const std::string command : {"info", "render", "check"})
    fails(place, command + " scene.ply", {"scene.ply: byte ", "expected"});
}

TEST_CASE("cli errors: images of different sizes are not compared") {
  const TemporaryFolder place;
  run(place, "render builtin:10 --scale 0.02 --out a");
  run(place, "render builtin:10 --scale 0.03 --out b");
  fails(place, "compare a/front.png b/front.png", {"b/front.png: expected 26x14 RGB", "found 38x22 RGB"});
  fails(place, "check builtin:10 --scale 0.02 --photos b",
        {"b/front.png: expected 26x14 or, before --scale, 1280x720 as the camera has it, found 38x22\n"});
}

TEST_CASE("cli errors: options that make no sense say what was expected") {
  const TemporaryFolder place;
  fails(place, "render builtin:10 --renderer serial/early/guess/ellipse",
        {"serial/early/guess/ellipse", "serial", "adaptive", "per-pixel", "opacity-box"});
  fails(place, "check builtin:10 --renderers 'nothing*'", {"nothing*", "swiftgs list"});
  for (const std::string command : {"render", "bench"})
    fails(place, command + " builtin:10 --harmonics double",
          {"--harmonics 'double'", "expected smallest, float or half"});
  for (const std::string views :
       {"25", "0,", "every:0", "every:x", "-1", "some", "0,1,99", "3-", "7-3", "0-25", "1-2-3"})
    fails(place, "render builtin:10 --views=" + views, {"--views '" + views + "'", "numbers from 0 to 24"});
  for (const std::string background :
       {"1,2", "1,0,x", "nan,0,0", "red", "1,0,1,0", "255,255,255", "0,0,-0.1"})
    fails(place, "render builtin:10 --background " + background, {background, "R,G,B", "0 to 1"});
  for (const std::string size :
       {"builtin:", "builtin:0", "builtin:-5", "builtin:1e9", "builtin:999999999999"})
    fails(place, "info " + size, {size, "builtin:N"});
  fails(place, "render builtin:10 --conventions other", {"other", "gsplat, inria or khronos"});
  fails(place, "render builtin:10 --format bmp", {"bmp", "png, pfm or exr"});
  fails(place, "info builtin:10 --spz-frame up", {"up", "specified, rub, rdf, luf or raw"});
  fails(place, "render builtin:10 --scale 0", {"--scale 0: expected a finite scale above 0"});
  fails(place, "render builtin:10 --scale inf", {"--scale", "finite scale above 0"});
  fails(place, "render builtin:10 --scale 1000", {"65536"});
  fails(place, "check builtin:10 --repeats 0", {"--repeats 0: expected at least 1"});
  for (const std::string command : {"render", "bench"})
    for (const std::string batch : {"0", "-3", "65537"})
      fails(place, command + " builtin:50 --batch=" + batch,
            {"--batch " + batch + ": expected 1 to 65536\n"});
  for (const std::string planes : {"depth", "alpha,depth", "alpha --format pfm"})
    fails(place, "render builtin:10 --planes " + planes,
          {"--planes: expected --format exr", "or alpha in a PNG\n"});
  fails(place, "render builtin:10 --planes alpha --background 0,1,0",
        {"--background 0,1,0: expected 0,0,0 in a PNG with alpha"});
  for (const std::string planes : {"colour", "features", "normals", "depth,depth", "alpha,"})
    for (const std::string command : {"render --format exr", "bench"})
      fails(place, command + " builtin:10 --planes " + planes,
            {"--planes '" + planes + "': expected names",
             "alpha, depth, squared_depth, first_depth, median_depth, normal, id, median_id; each once\n"});
}

TEST_CASE("cli errors: arguments that are not known or missing") {
  const TemporaryFolder place;
  fails(place, "", {"expected a command: info, list, render, compare, check", "--help"});
  fails(place, "paint", {"command 'paint' is not known (see", "--help"});
  fails(place, "RENDER builtin", {"command 'RENDER' is not known, did you mean 'render'?"});
  fails(place, "render", {"swiftgs: render: expected SCENE (see swiftgs render --help)"});
  fails(place, "prune builtin --out a.ply", {"swiftgs: prune: expected --keep (see"});
  const std::string list = run(place, "list").out;
  if (!contains(list, "vulkan/")) {
    fails(place, "render builtin:10 --renderer vulkan/early/per-pixel/ellipse", {"built without Vulkan"});
    fails(place, "check builtin:10 --renderers 'vulkan/*'", {"built without Vulkan"});
  }
  if (!contains(list, "cuda/")) {
    fails(place, "render builtin:10 --renderer cuda/early/per-pixel/ellipse", {"built without CUDA"});
    fails(place, "check builtin:10 --renderers 'cuda/*'", {"built without CUDA"});
    fails(place, "prune builtin:20 --keep 0.5 --backend cuda --out a.ply", {"built without CUDA"});
  }
  fails(place, "--frobnicate", {"swiftgs: '--frobnicate' is not expected (see swiftgs --help)"});
  fails(place, "render buildin:50",
        {"swiftgs: buildin:50: No such file or directory, did you mean 'builtin'?"});
  fails(place, "info /dev/null", {"swiftgs: /dev/null: expected a regular file\n"});
  fails(place, "render builtin:10 --sclae 0.5 here --stat",
        {"render: '--sclae' is not expected, did you mean '--scale'?; "
         "'--stat' is not expected, did you mean '--stats'? (see"});
  // The unknown option's value takes the scene's place.
  fails(place, "render --backgrund 1,1,1 builtin:10",
        {"render: '--backgrund' is not expected, did you mean '--background'? (see"});
  fails(place, "render builtin:10 -scale 0.5", {"is not expected, did you mean '--scale'? (see"});
  fails(place, "check builtin:10 here there",
        {"check: 'here' is not expected; 'there' is not expected (see"});
  fails(place, "render builtin:10 --scale big", {"swiftgs: --scale 'big': expected a number (see"});
  fails(place, "check builtin:10 --repeats 1.5", {"swiftgs: --repeats '1.5': expected a whole number (see"});
  fails(place, "render builtin:10 --scale", {"swiftgs: --scale: expected a value, found nothing (see"});
  fails(place, "render builtin:10 --out=", {"swiftgs: --out: expected a value, found nothing (see"});
  fails(place, "render builtin:10 --out a --out b", {"swiftgs: --out: expected one value, found 2 (see"});
  fails(place, "render builtin:10 --stats=maybe", {"swiftgs: --stats 'maybe': expected no value (see"});
  fails(place, "compare one.png", {"B", "--help"});
}

TEST_CASE("cli errors: no option or argument takes an empty value") {
  const TemporaryFolder place;
  const auto refuses = [&](const std::string& arguments, const std::string& name) {
    fails(place, arguments, {"swiftgs: " + name + ": expected a value, found nothing (see"});
  };
  for (const std::string name : {"--cameras", "--views", "--json", "--renderer", "--background", "--scale"})
    refuses("render builtin:10 " + name + " ''", name);
  refuses("check builtin:10 --photos ''", "--photos");
  refuses("bench builtin:10 --gaussians ''", "--gaussians");
  refuses("stress --families ''", "--families");
  refuses("prune builtin:10 --keep 0.5 --out ''", "--out");
  refuses("list --json ''", "--json");
  for (const std::string command : {"info", "render", "bench builtin:10"}) refuses(command + " ''", "SCENE");
  refuses("compare '' ''", "A");
  refuses("compare a.png ''", "B");
  refuses("report ''", "RESULTS");
  CHECK_FALSE(std::filesystem::exists(place / "renders"));
}

TEST_CASE("cli errors: results that cannot be written are named with the reason") {
  const TemporaryFolder place;
  place.write("file", "");
  fails(place, "render builtin:10 --scale 0.01 --out file/inside", {"swiftgs: file/inside: Not a directory"});
  fails(place,
        "check builtin:10 --scale 0.01 --repeats 1 --json file/x.json --renderers "
        "serial/early/per-pixel/ellipse",
        {"swiftgs: file/x.json: Not a directory"});
  // Before anything is rendered.
  CHECK(swiftgs::test::swiftgs(place, "check builtin:10 --repeats 1 --json missing/x.json").out == "");
}

TEST_CASE("cli errors: an image that a limit cuts is named and leaves nothing") {
  const TemporaryFolder place;
  const Outcome outcome = run_after(place, "ulimit -f 8", "render builtin:1000 --scale 0.3 --out images");
  CHECK(outcome.code == 1);
  CHECK(outcome.err == "swiftgs: images/front.png: File too large\n");
  CHECK(std::filesystem::is_empty(place / "images"));
}

TEST_CASE("cli errors: a standard output that takes nothing is an error") {
  if (!std::filesystem::exists("/dev/full")) return swiftgs::test::skip("no /dev/full here");
  const TemporaryFolder place;
  for (const auto& [arguments, reason] :
       {std::pair<std::string, std::string>{"info builtin:10", "cannot be written"},
        {"list --json -", "No space left on device"}}) {
    CHECK(swiftgs::test::swiftgs(place, arguments + " >/dev/full 2>full.txt #").code == 1);
    CHECK(content_of(place / "full.txt") == "swiftgs: standard output: " + reason + "\n");
  }
}

}  // namespace swiftgs::test::errors_test
