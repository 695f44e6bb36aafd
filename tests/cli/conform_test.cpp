// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/command.hpp"
#include "cli/json_in.hpp"

namespace swiftgs::test::conform_test {

namespace {

/// A set of two clauses, `large` with a limit of alphas of its own and `small`, whose splats are a pixel
/// wide. Images that `render` draws of them are called as the clauses are.
void write_set(const TemporaryFolder& place, const std::string& change = R"("alpha_max": 0.9)") {
  swiftgs::Scene scene = swiftgs::make_builtin_scene(150);
  for (vec3& colour : scene.sh0) colour *= 0.3f;  // within 0 to 1, as bytes are
  std::fill(scene.sh_rest.begin(), scene.sh_rest.end(), 0.0f);
  for (const char* name : {"large", "small"}) {
    place.write("set/" + std::string(name) + "/cameras.json",
                "[{\"id\": 0, \"img_name\": \"" + std::string(name) +
                    "\", \"width\": 24, \"height\": 24, \"fx\": 30, \"fy\": 30, \"position\": [0, 0, -5], "
                    "\"rotation\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}]");
    write_scene(place / "set" / name / "scene.ply", scene);
    for (vec3& scale : scene.scales) scale *= 0.1f;
  }
  const auto clause = [](const std::string& name, const std::string& more) {
    return "{\"name\": \"" + name + "\", \"meaning\": \"\", \"scene\": \"" + name +
           "/scene.ply\", \"cameras\": \"" + name +
           "/cameras.json\", \"layers\": 9, \"presets\": {\"gsplat\": \"\", \"khronos\": \"\"}" + more + "}";
  };
  place.write("set/manifest.json", R"({"side": 24, "clauses": [)" +
                                       clause("large", ", \"conventions\": {" + change + "}") + ", " +
                                       clause("small", "") +
                                       R"(], "variants": [{"name": "blur 0.1", "conventions": {"blur": 0.1}},
                      {"name": "by distance", "conventions": {"order": "distance"}}]})");
}

/// Draws `clause` into the folder `canvases`.
void draw(const TemporaryFolder& place, const std::string& clause, const std::string& options) {
  run(place, "render set/" + clause + "/scene.ply --cameras set/" + clause + "/cameras.json --out canvases " +
                 options);
}

}  // namespace

TEST_CASE("cli: conform finds that a renderer follows its preset") {
  const TemporaryFolder place;
  write_set(place);
  const std::string text =
      run(place, "conform --set set --renderer serial/early/per-pixel/ellipse --json out.json").out;
  check_holds(text, {"large               right ", "2 of 2 clauses right by gsplat\n"});
  const json results = json_in(place / "out.json");
  CHECK(results["format"] == "swiftgs-conform");
  CHECK(results["preset"] == "gsplat");
  REQUIRE(results["rows"].size() == 2);
  CHECK(results["rows"][1]["clause"] == "small");
  CHECK(results["rows"][1]["wrong"] == 0);
  CHECK(results["rows"][1]["db"] > 120);
}

TEST_CASE("cli: conform names the conventions that a canvas follows") {
  const TemporaryFolder place;
  write_set(place);
  draw(place, "small", "--renderer reference --format npy --model blur=0.1");
  const Outcome outcome = swiftgs(place, "conform canvases --set set --json out.json");
  CHECK(outcome.code == 1);
  CHECK(outcome.err == "swiftgs: conform: 0 of 2 clauses right by gsplat\n");
  check_holds(outcome.out, {"large               not drawn\n", "blur 0.1 (", " dB, every pixel)\n"});
  const json row = json_in(place / "out.json")["rows"][1];
  CHECK(row["verdict"] == "differs");
  CHECK(row["nearest"] == json({"blur 0.1"}));
  CHECK(row["explained"] == true);
  CHECK(row["nearest_db"] > row["db"].get<double>() + 20);

  draw(place, "small", "--renderer reference --format npy --conventions khronos");
  CHECK(contains(swiftgs(place, "conform canvases --set set").out, "  preset khronos ("));
  check_holds(swiftgs(place, "conform canvases --set set --preset khronos").out,
              {"small               right "});
}

TEST_CASE("cli: conform reads bytes of which colours are premultiplied or not") {
  const TemporaryFolder place;
  write_set(place, "");
  const std::string judge = "conform canvases --set set";
  for (const char* clause : {"large", "small"})
    draw(place, clause, "--renderer reference --format png --planes alpha");
  CHECK(contains(swiftgs(place, judge).err, "0 of 2"));
  // A colour that was divided and rounded is off by more than half a step of the premultiplied one at times.
  CHECK(contains(swiftgs(place, judge + " --straight --blends-in-bytes").out, "2 of 2"));
  for (const char* clause : {"large", "small"}) {
    const std::string name = std::string("canvases/") + clause;
    const Image image = read_image(place / (name + ".png"));
    std::string bytes;
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      bytes += char(int(255 * image.pixels[i] * (i % 4 < 3 ? image.pixels[i - i % 4 + 3] : 1) + 0.5f));
    std::filesystem::remove(place / (name + ".png"));
    place.write(name + ".rgba", bytes);
  }
  CHECK(contains(swiftgs(place, judge + " --blends-in-bytes").out, "2 of 2"));
}

TEST_CASE("cli: conform refuses what is no set and no canvas") {
  const TemporaryFolder place;
  fails(place, "conform", {"conform: expected a folder of canvases, or --renderer"});
  fails(place, "conform none", {"none: expected a folder"});
  place.write("canvases/large.npy", "none");
  fails(place, "conform canvases --set set", {"set/manifest.json: "});
  write_set(place, R"("blurr": 0.1)");
  fails(place, "conform canvases --set set", {"set/manifest.json: ", "'blurr' is not known"});
  write_set(place, R"("order": "x")");
  fails(place, "conform canvases --set set", {"set/manifest.json: ", "order is \"x\""});
  write_set(place);
  fails(place, "conform canvases --set set", {"large.npy: byte 0: expected an array of NumPy"});
  fails(place, "conform canvases --set set --preset paper", {"'paper'", "gsplat, inria or khronos"});
  place.write("canvases/large.rgba", std::string(4 * 24 * 23, '\0'));
  std::filesystem::remove(place / "canvases/large.npy");
  fails(place, "conform canvases --set set", {"large.rgba: expected 24x24 pixels of 3 or 4 channels"});
  place.write("set/manifest.json", "{\"side\": 24}");
  fails(place, "conform canvases --set set", {"set/manifest.json: expected the manifest", "clauses"});
}

}  // namespace swiftgs::test::conform_test
