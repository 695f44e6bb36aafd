// SPDX-License-Identifier: Apache-2.0
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/cameras.hpp"
#include "cli/command.hpp"
#include "cli/json_in.hpp"

namespace swiftgs::test::prune_test {

namespace {

/// Expects one line of error that holds `part`, and no file `small.ply`.
void fails(const TemporaryFolder& place, const std::string& arguments, const std::string& part) {
  swiftgs::test::fails(place, "prune " + arguments, {part});
  CHECK_FALSE(std::filesystem::exists(place / "small.ply"));
}

const std::string small_views = " --scale 0.05 --backend serial ";

}  // namespace

TEST_CASE("cli prune: writes as many Gaussians as asked for and says what they weigh") {
  const TemporaryFolder place;
  const std::string text = run(place, "prune builtin:2000 --keep 0.25 --out small.ply" + small_views).out;
  CHECK(text.starts_with("small.ply: kept 500 of 2000 Gaussians, with "));
  check_holds(text, {"% of the weight in the views\n", "\nbefore         2000 ", "\nafter           500 "});
  const swiftgs::Scene small = swiftgs::load_scene(place / "small.ply");
  CHECK(small.size() == 500);
  CHECK(small.sh_degree == 3);
  run(place, "render small.ply --scale 0.05");
}

TEST_CASE("cli prune: writes one object of results with exactly these members") {
  const TemporaryFolder place;
  run(place, "prune builtin:1000 --keep 0.3 --out small.ply --json contribution.json" + small_views);
  run(place, "prune builtin:1000 --keep 0.3 --score opacity-volume --out small.ply --json volume.json" +
                 small_views);
  for (const std::string name : {"contribution", "volume"}) {
    const json result = json_in(place / (name + ".json"));
    CHECK(members_of(result) == std::set<std::string>{"format", "version", "machine", "command", "notes",
                                                      "scene", "score", "keep", "backend", "conventions",
                                                      "views", "held_out", "kept_weight", "before", "after"});
    check_members(result, R"({"backend": "serial", "scene": "builtin:1000", "held_out": 4})");
    CHECK(contains(result["command"], "swiftgs prune builtin:1000 --keep 0.3 "));
    CHECK(result["before"]["gaussians"] == 1000);
    check_members(result["after"], R"({"gaussians": 300, "photo_psnr_db": null})");
    CHECK(result["after"]["ms"] > 0);
    // A front view and an orbit of 24: every eighth is held out.
    CHECK(result["views"] == (name == "volume" ? 0 : 21));
    CHECK(result["kept_weight"] > 0.3);
    CHECK(result["kept_weight"] <= 1);
  }
}

TEST_CASE("cli prune: views that are left out are compared with their photographs") {
  const TemporaryFolder place;
  run(place, "render builtin:1000 --scale 0.05 --views every:8 --out photos");
  run(place,
      "prune builtin:1000 --keep 0.02 --photos photos --out small.ply --json results.json" + small_views);
  const json result = json_in(place / "results.json");
  // The photographs are these very frames in 8 bits.
  CHECK(result["before"]["photo_psnr_db"] > 50);
  CHECK(result["before"]["photo_ssim"] > 0.99);
  CHECK(result["after"]["photo_psnr_db"] < result["before"]["photo_psnr_db"]);
  CHECK(result["after"]["photo_psnr_db"].get<double>() ==
        doctest::Approx(result["after"]["unpruned_psnr_db"].get<double>()).epsilon(0.01));
}

TEST_CASE("cli prune: nothing is written in the place of what is read or of another result") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(100));
  place.write("cameras.ply", "[]");
  const std::string before = content_of(place / "scene.ply");
  const std::string by_volume = "scene.ply --keep 0.5 --score opacity-volume ";
  fails(place, by_volume + "--out scene.ply", "--out scene.ply: expected another file than that of SCENE");
  fails(place, by_volume + "--out small.ply --json scene.ply", "--json scene.ply: expected another file");
  fails(place, by_volume + "--out small.ply --json small.ply",
        "--json small.ply: expected another file than that of --out");
  fails(place, by_volume + "--cameras cameras.ply --out cameras.ply", "that of --cameras");
  CHECK(content_of(place / "scene.ply") == before);
}

TEST_CASE("cli prune: what cannot be done is one line and writes nothing") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(20));
  place.write("photos/none.png", "");
  const std::string out = " --out small.ply ";
  for (const std::string keep : {"0", "1.5", "nan"})
    fails(place, "builtin:20 --keep=" + keep + out,
          "--keep " + keep + ": expected a part of the Gaussians above 0");
  fails(place, "builtin:20 --keep 0.5 --score size" + out, "expected contribution or opacity-volume");
  fails(place, "builtin:20 --keep 0.5 --backend abacus" + out, "backend 'abacus' is not known; expected ");
  fails(place, "builtin:20 --keep 0.5 --out small.spz", "ends in .ply");
  fails(place, "builtin:20 --keep 0.5 --out missing/small.ply", "missing/small.ply: No such file");
  fails(place, "builtin:20 --keep 0.5 --json missing/x.json" + out, "missing/x.json: No such file");
  fails(place, "scene.ply --keep 0.5" + out, "--score contribution: expected --cameras");
  fails(place, "scene.ply --keep 0.5 --score opacity-volume --photos photos" + out, "--cameras");
  fails(place, "builtin:20 --keep 0.5 --photos photos" + out, "photos: expected photographs of views");
  fails(place, "builtin:20 --keep 0.5 --views all --photos photos" + out, "that --views 'all' leaves out");
  fails(place, "builtin:20 --keep 0.5 --views except:1" + out, "--views 'except:1': expected to leave some");
  fails(place, "builtin:20 --keep 0.5 --views except:" + out, "numbers from 0 to 24");
}

TEST_CASE("cli prune: views that show nothing of the scene are an error") {
  const TemporaryFolder place;
  write_scene(place / "scene.ply", swiftgs::make_builtin_scene(20));
  json cameras = json::parse(cameras_json({"away", "away"}));
  for (json& camera : cameras)
    camera["position"] = {0, 1e6, 0}, camera["rotation"] = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
  place.write("cameras.json", cameras.dump());
  const std::string command = "scene.ply --keep 0.5 --cameras cameras.json --backend serial ";
  fails(place, command + "--out small.ply", "expected views that show the scene");
  // What an earlier run left stays.
  place.write("earlier.ply", "a scene"), place.write("earlier.json", "its results");
  fails(place, command + "--out earlier.ply --json earlier.json", "expected views that show the scene");
  CHECK(content_of(place / "earlier.ply") == "a scene");
  CHECK(content_of(place / "earlier.json") == "its results");
}

}  // namespace swiftgs::test::prune_test
