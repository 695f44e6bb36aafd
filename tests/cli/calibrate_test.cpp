// SPDX-License-Identifier: Apache-2.0
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/sort_calibrations.hpp>

#include "cli/command.hpp"

using namespace swiftgs::test;

namespace {

const std::string name = "serial/adaptive/per-pixel/ellipse";
const std::string adaptive = " --scale 0.05 --renderer " + name;

}  // namespace

TEST_CASE("cli calibrate: adds a measurement for a size and says what it chose") {
  const TemporaryFolder place;
  const std::string told = run(place, "calibrate builtin:300 --out b.json" + adaptive).out;
  CHECK(told.starts_with(name + ", 64x36, 1 view: standard "));
  CHECK(lines_in(told) == 1);
  const auto saved = swiftgs::read_sort_calibrations(place / "b.json");
  REQUIRE(saved.size() == 1);
  CHECK(saved[0].key.renderer == name);
  CHECK(saved[0].key.scene == swiftgs::geometry_checksum(swiftgs::make_builtin_scene(300)));
  CHECK(saved[0].measured.gaussians == 300);
  CHECK(saved[0].measured.width == 64);
  CHECK(saved[0].measured.standard_ms > 0);
  CHECK(saved[0].measured.early_ms > 0);
  CHECK(contains(told, saved[0].measured.prefers_early() ? ", choice early\n" : ", choice standard\n"));
  run(place, "calibrate builtin:300 --out b.json --views 0" + adaptive);
  run(place, "calibrate builtin:200 --out b.json --views 0" + adaptive);
  CHECK(swiftgs::read_sort_calibrations(place / "b.json").size() == 2);
}

TEST_CASE("cli calibrate: render draws the same image with the file and refuses one that does not fit") {
  const TemporaryFolder place;
  run(place, "calibrate builtin:300 --out b.json --views 0" + adaptive);
  const std::string render = " --views 0 --format pfm --calibration b.json --out ";
  run(place, "render builtin:300 --views 0 --format pfm --out without" + adaptive);
  run(place, "render builtin:300" + render + "with" + adaptive);
  CHECK(content_of(place / "with/front.pfm") == content_of(place / "without/front.pfm"));

  const auto refused = [&](const std::string& arguments, const std::string& part) {
    fails(place, arguments, {part});
  };
  const std::string scene = "render builtin:300" + render + "x --renderer ";
  refused("render builtin:301" + render + "x" + adaptive, "b.json: expected a calibration of scene crc32:");
  refused(scene + "serial/early/per-pixel/ellipse", "b.json: expected a calibration of scene crc32:");
  refused(scene + name + " --scale 0.06", "b.json: expected a calibration at 77x43, as the view front has");
  place.write("b.json", "notes");
  refused(scene + name, "b.json: byte 1: expected valid JSON");
  refused("calibrate builtin:300 --out b.json" + adaptive, "b.json: byte 1: expected valid JSON");
  std::filesystem::remove(place / "b.json");
  refused(scene + name, "b.json: No such file or directory");
  refused("calibrate builtin:300 --out b.json --renderer serial/early/per-pixel/ellipse",
          "--renderer serial/early/per-pixel/ellipse: expected the sort 'adaptive'");
}
