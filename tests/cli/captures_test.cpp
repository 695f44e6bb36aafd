// SPDX-License-Identifier: Apache-2.0
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/cameras.hpp"
#include "cli/json_in.hpp"
#include "cli/pictures.hpp"

namespace swiftgs::test::captures_test {

namespace {

void write_capture(const TemporaryFolder& place, const std::string& folder) {
  place.write(folder + "/cameras.json", cameras_json({"a.jpg", "b.jpg"}));
  write_scene(place / (folder + "/scene.ply"), swiftgs::make_builtin_scene(100));
}

const std::string serial = " --renderers serial/early/per-pixel/ellipse";

}  // namespace

TEST_CASE("cli captures: every command takes the folder of a capture for its scene and its cameras") {
  const TemporaryFolder place;
  write_capture(place, "garden");
  CHECK(contains(run(place, "info garden").out, "Gaussians       100\n"));
  run(place, "render garden/ --out images");
  CHECK(files_in(place / "images") == std::set<std::string>{"a.png", "b.png"});
  CHECK(contains(run(place, "check garden --repeats 1 --views 1" + serial).out, " b "));
  run(place, "prune garden --keep 0.5 --views 0 --backend serial --out small.ply");
  CHECK(swiftgs::load_scene(place / "small.ply").size() == 50);
  run(place, "bench garden --errors none --views 1 --max-frames 2 --min-frames 2 --json r.json" + serial);
  check_members(json_in(place / "r.json")["rows"][0], R"({"scene": "scene", "view": "b"})");
}

TEST_CASE("cli captures: photographs of the folder are compared with where views are its own") {
  const TemporaryFolder place;
  write_capture(place, "garden");
  CHECK(json::parse(run(place, "info garden --json -").out)["photos"].is_null());
  run(place, "render garden --out garden/photos --views 0");  // the frame itself, in 8 bits
  const json info = json::parse(run(place, "info garden/ --json -").out);
  check_members(info, R"({"cameras": "garden/cameras.json", "photos": "garden/photos"})");
  CHECK(contains(run(place, "info garden").out, "photographs     garden/photos\n"));

  const auto checked = [&](const std::string& arguments) {
    run_noting(place, "check " + arguments + " --repeats 1 --json r.json" + serial);
    return json_in(place / "r.json")["rows"];
  };
  const json rows = checked("garden --views all");
  CHECK(rows[0]["photo_psnr_db"] > 50);
  CHECK(rows[1]["photo_psnr_db"].is_null());
  for (const std::string other : {"garden --views 1", "garden --views 0 --cameras garden",
                                  "garden/scene.ply --cameras garden --views 0"})
    CHECK_FALSE(checked(other)[0].contains("photo_psnr_db"));
  CHECK(checked("garden/scene.ply --cameras garden --views 0 --photos garden/photos")[0]["photo_psnr_db"] >
        50);

  CHECK(checked("garden --views 0 --scale 0.5")[0]["photo_psnr_db"] > 20);

  const auto pruned = [&](const std::string& arguments) {
    run(place,
        "prune garden --keep 0.5 --views 1 --backend serial --out small.ply --json p.json" + arguments);
    return json_in(place / "p.json")["before"]["photo_psnr_db"];
  };
  CHECK(pruned("") > 50);
  CHECK(pruned(" --scale 0.5") > 20);
}

TEST_CASE("cli views: images are chosen by name with or without extension") {
  const TemporaryFolder place;
  place.write("cameras.json", cameras_json({"left/a.jpg", "b.JPG", "b-2.JPG", "0003.png", "3.png"}));
  const auto drawn = [&](const std::string& views) {
    return names_drawn(place, "builtin:20 --cameras cameras.json --views " + views);
  };
  using Names = std::set<std::string>;
  CHECK(drawn("left/a.jpg") == Names{"left_a.png"});
  CHECK(drawn("left/a") == Names{"left_a.png"});
  CHECK(drawn("left_a") == Names{"left_a.png"});
  CHECK(drawn("b,b-2.JPG") == Names{"b.png", "b-2.png"});
  // By name: 0003.png, 3.png, b-2.JPG, b.JPG, left/a.jpg.
  CHECK(drawn("0003") == Names{"0003.png"});
  CHECK(drawn("3") == Names{"b.png"});
  CHECK(drawn("3.png") == Names{"3.png"});
  CHECK(drawn("03") == Names{"b.png"});
  CHECK(drawn("0-1,b") == Names{"0003.png", "3.png", "b.png"});

  place.write("cameras.json", cameras_json({"./train/r_0", ".././c.jpg", ".hidden"}));
  CHECK(drawn("all") == Names{"train_r_0.png", "c.png", ".hidden.png"});
  CHECK(drawn("train_r_0") == Names{"train_r_0.png"});
}

TEST_CASE("cli views: a name that no image has brings up the nearest") {
  const TemporaryFolder place;
  place.write("cameras.json", cameras_json({"DSC08042.JPG", "DSC08050.JPG"}));
  const std::string render = "render builtin:20 --cameras cameras.json --views ";
  fails(place, render + "DSC08042,DSC0805.JPG",
        {"swiftgs: --views 'DSC08042,DSC0805.JPG': no image is called 'DSC0805.JPG', did you mean "
         "'DSC08050.JPG'?\n"});
  fails(place, render + "DSC08051", {"did you mean 'DSC08050'?"});
  fails(place, render + "something-else", {"expected all, every:N, except:N, or names", "from 0 to 1"});
  fails(place, "render builtin:20 --views orbit-0", {"did you mean 'orbit-00'?"});
}

TEST_CASE("cli cameras: cameras are refused before the scene is looked at") {
  const TemporaryFolder place;
  place.write("broken.json", "[{\"id\": 0}]");
  place.write("capture/cameras.json", "[{\"id\": 0}]");
  place.write("capture/scene.ply", "no scene");
  place.write("cameras.json", cameras_json({"a.jpg"}));
  for (const std::string command : {"render", "check", "prune --keep 1 --out x.ply"}) {
    fails(place, command + " capture", {"capture/cameras.json: byte "});
    // The missing scene is not named, so nobody has looked for it.
    fails(place, command + " missing.ply --cameras broken.json", {"broken.json: byte "});
    fails(place, command + " missing.ply --cameras cameras.json --views 99", {"--views '99'"});
  }
  for (const std::string scene : {"capture", "capture/missing.ply --views 99"})
    fails(place, "bench " + scene, {"capture/cameras.json: byte "});
  fails(place, "render missing.ply --background red", {"--background 'red'"});
  fails(place, "render missing.ply --views 1", {"--views '1'"});
  fails(place, "render missing.ply --scale 0", {"--scale"});
}

}  // namespace swiftgs::test::captures_test
