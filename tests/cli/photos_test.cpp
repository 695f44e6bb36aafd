// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "cli/cameras.hpp"
#include "cli/command.hpp"
#include "cli/json_in.hpp"

namespace swiftgs::test::photos_test {

namespace fs = std::filesystem;

namespace {

/// Two cameras whose images differ, called `names`.
void write_cameras(const TemporaryFolder& place, const std::vector<std::string>& names) {
  json cameras = json::parse(cameras_json(names));
  for (std::size_t i = 0; i < names.size(); ++i) cameras[i]["position"] = {0.4 * double(i), -1, -4};
  place.write("cameras.json", cameras.dump());
}

const std::string check =
    "check builtin:200 --cameras cameras.json --repeats 1 --renderers serial/early/per-pixel/ellipse --json "
    "r.json";

/// Whether each view of `arguments`, in the order of the names, is compared with its own photograph, with
/// none, or with another.
std::string compared(const TemporaryFolder& place, const std::string& arguments) {
  run_noting(place, check + " " + arguments);
  const json result = json_in(place / "r.json");
  std::string told;
  for (const json& row : result["rows"]) {
    const json psnr = row.value("photo_psnr_db", json());
    told += psnr.is_null() ? "none " : psnr > 50 ? "own " : "other ";
  }
  return told;
}

/// Draws the cameras into files of these names in `folder`, one for each.
void draw(const TemporaryFolder& place, const std::vector<std::string>& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    run(place, "render builtin:200 --cameras cameras.json --out drawn --views " + std::to_string(i) +
                   " --json drawn.json");
    const fs::path file = place / files[i];
    fs::create_directories(file.parent_path());
    fs::copy_file(place / std::string(json_in(place / "drawn.json")["rows"][0]["image"]), file);
  }
}

}  // namespace

// COLMAP 3.12's rig_configurator: a folder for each camera of a rig, with the same names in it.
TEST_CASE("cli photographs: images in sub-folders are compared by their path") {
  const TemporaryFolder place;
  write_cameras(place, {"left/0001.png", "right/0001.png"});
  draw(place, {"images/left/0001.png", "images/right/0001.png"});
  CHECK(compared(place, "--views all --photos images") == "own own ");
  CHECK(compared(place, "--views all --photos images/left") == "own none ");
  CHECK(compared(place, "--views all --photos images/right/") == "none own ");
  CHECK(compared(place, "--views left/0001 --photos ./images/left/.") == "own ");
  // The other camera has the name, too, though it is not asked for.
  fails(place, check + " --views right/0001 --photos images/left",
        {"images/left: expected a photograph with the path of a view, such as right/0001.png"});

  fs::create_directories(place / "flat");
  fs::copy_file(place / "images/left/0001.png", place / "flat/0001.png");
  fails(place, check + " --views all --photos flat",
        {"flat: expected a photograph", "such as left/0001.png"});
  fs::remove(place / "images/right/0001.png");
  CHECK(compared(place, "--views all --photos images") == "own none ");
}

TEST_CASE("cli photographs: views without one are counted where others have one") {
  const TemporaryFolder place;
  write_cameras(place, {"left/0001.png", "right/0001.png"});
  draw(place, {"photos/left/0001.png", "photos/right/0001.png"});
  CHECK(run(place, check + " --views all --photos photos").err.empty());
  const std::string note = "photos: 1 of 2 views have no photograph, such as right/0001.png.";
  fs::remove(place / "photos/right/0001.png");
  CHECK(contains(run_noting(place, check + " --views all --photos photos").err, "swiftgs: " + note + "\n"));
  CHECK(json_in(place / "r.json")["notes"] == json::array({note}));
  // A capture is measured twice, and the note said once.
  swiftgs::write_scene(place / "scene.ply", swiftgs::make_builtin_scene(50));
  run_noting(
      place,
      "bench . --views all --gaussians 20,50 --renderers serial/early/per-pixel/ellipse --min-frames 2 "
      "--max-frames 2 --json r.json");
  CHECK(json_in(place / "r.json")["notes"] == json::array({"./" + note}));
}

// A data set is often a folder of links.
TEST_CASE("cli photographs: linked folders are looked into") {
  const TemporaryFolder place;
  write_cameras(place, {"left/0001.png", "right/0001.png"});
  draw(place, {"data/0001.png", "photos/right/0001.png"});
  fs::create_directory_symlink(place / "data", place / "photos/left");
  // Links without an end, to the folder itself and to one above it.
  fs::create_directory_symlink(".", place / "photos/here");
  fs::create_directory_symlink("../..", place / "photos/right/above");
  fs::create_symlink("nowhere", place / "photos/left/broken.png");
  CHECK(compared(place, "--views all --photos photos") == "own own ");
}

// A transforms.json of nerfstudio names images/frame_00001.jpg; Windows writes backslashes.
TEST_CASE("cli photographs: folders that lead to the images may be others") {
  const TemporaryFolder place;
  write_cameras(place, {"./images/a.jpg", "images/cam\\\\b.jpg"});
  draw(place, {"photos/a.png", "photos/cam/b.png"});
  CHECK(compared(place, "--views all --photos photos") == "own own ");
  fs::rename(place / "photos", place / "images");
  CHECK(compared(place, "--views all --photos images") == "own own ");
  CHECK(compared(place, "--views all --photos images/cam") == "none own ");
  // By a name that no other image and no other file has.
  fs::create_directories(place / "images/jpeg");
  fs::rename(place / "images/a.png", place / "images/jpeg/a.png");
  CHECK(compared(place, "--views all --photos images") == "own own ");
}

TEST_CASE("cli photographs: names with dots keep them") {
  const TemporaryFolder place;
  // INRIA's cameras.json has names without extension.
  write_cameras(place, {"frame.0001", "frame.0002.JPG"});
  run(place, "render builtin:200 --cameras cameras.json --out photos");
  CHECK(fs::exists(place / "photos/frame.0001.png"));
  CHECK(fs::exists(place / "photos/frame.0002.png"));
  CHECK(compared(place, "--views all --photos photos") == "own own ");
  fs::remove(place / "photos/frame.0001.png");
  CHECK(compared(place, "--views all --photos photos") == "none own ");
}

TEST_CASE("cli photographs: several photographs of one image are refused unless one has its extension") {
  const TemporaryFolder place;
  write_cameras(place, {"a", "b.png"});
  draw(place, {"photos/a.png", "photos/b.png"});
  fs::copy_file(place / "photos/a.png", place / "photos/b.jpg");
  place.write("photos/a.txt", "of another kind");
  CHECK(compared(place, "--views all --photos photos") == "own own ");
  fs::copy_file(place / "photos/a.png", place / "photos/a.jpg");
  fails(place, check + " --views all --photos photos",
        {"swiftgs: photos: expected one photograph of a, found a.jpg and a.png\n"});
}

TEST_CASE("cli photographs: --scale scales them with the images") {
  const TemporaryFolder place;
  write_cameras(place, {"a.png"});
  // Wide enough for a side that is rounded: half of it is a whole number, a third is not.
  json cameras = json_in(place / "cameras.json");
  cameras[0]["width"] = 40, cameras[0]["height"] = 20;
  place.write("cameras.json", cameras.dump());
  run(place, "render builtin:200 --cameras cameras.json --out photos");
  const auto psnr_at = [&](const std::string& scale) -> double {
    run(place, check + " --photos photos --scale " + scale);
    return json_in(place / "r.json")["rows"][0]["photo_psnr_db"];
  };
  CHECK(psnr_at("1") > 50);
  // The mean over each pixel's area, of the drawn image in 8 bits.
  const swiftgs::Image photo = swiftgs::read_image(place / "photos/a.png");
  for (const auto& [factor, width, height] : {std::tuple{0.5, 20, 10}, {0.3, 12, 6}, {2.0, 80, 40}}) {
    const double scale = factor;
    CAPTURE(scale);
    run(place, "render builtin:200 --cameras cameras.json --format pfm --out scaled --scale " +
                   std::to_string(scale));
    const swiftgs::Image drawn = swiftgs::read_image(place / "scaled/a.pfm");
    REQUIRE(drawn.width == width);
    REQUIRE(drawn.height == height);
    double squares = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c) {
          double sum = 0, area = 0;
          for (int v = 0; v < photo.height; ++v)
            for (int u = 0; u < photo.width; ++u) {
              const auto common = [&](int at, int of) {
                return std::max(0.0, std::min(at + 1.0, (of + 1) / scale) - std::max(double(at), of / scale));
              };
              const double part = common(u, x) * common(v, y);
              sum += part * photo.pixels[std::size_t((v * photo.width + u) * 3 + c)], area += part;
            }
          const double shown =
              std::clamp(double(drawn.pixels[std::size_t((y * width + x) * 3 + c)]), 0.0, 1.0);
          squares += std::pow(shown - sum / area, 2);
        }
    const double expected = -10 * std::log10(squares / (3.0 * width * height));
    CHECK(psnr_at(std::to_string(scale)) == doctest::Approx(expected).epsilon(1e-4));
  }
  // One that has the scaled size already is taken as it is.
  run(place, "render builtin:200 --cameras cameras.json --out photos --scale 0.25");
  CHECK(psnr_at("0.25") > 50);
  fails(place, check + " --photos photos --scale 0.5",
        {"photos/a.png: expected 20x10 or, before --scale, 40x20 as the camera has it, found 10x5\n"});
  fails(place, check + " --photos photos",
        {"photos/a.png: expected 40x20 as the camera has it, found 10x5\n"});
}

TEST_CASE("cli photographs: alpha is blended over the background, and grey is read as RGB") {
  const TemporaryFolder place;
  write_cameras(place, {"a.png"});
  const std::string behind = " --background 0.25,0.5,1";
  // A picture with alpha, as trainers of cut out objects have them.
  run(place, "render builtin:5 --cameras cameras.json --planes alpha --out photos");
  REQUIRE(swiftgs::read_image(place / "photos/a.png").channels == 4);
  const auto is_own = [&](const std::string& background) {
    run_noting(place,
               "check builtin:5 --cameras cameras.json --repeats 1 --json r.json --photos photos "
               "--renderers serial/early/per-pixel/ellipse" +
                   background);
    return json_in(place / "r.json")["rows"][0]["photo_psnr_db"] > 50;
  };
  CHECK(is_own(""));
  CHECK(is_own(behind));
  run(place, "render builtin:5 --cameras cameras.json --out photos" + behind);
  REQUIRE(swiftgs::read_image(place / "photos/a.png").channels == 3);
  CHECK(is_own(behind));
  CHECK_FALSE(is_own(""));
}

}  // namespace swiftgs::test::photos_test
