// SPDX-License-Identifier: Apache-2.0
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/sort_calibrations.hpp>

#include "io/files.hpp"

using namespace swiftgs;
using namespace swiftgs::test;
namespace fs = std::filesystem;

namespace {

SavedSortCalibration usual() {
  return {{.scene = "crc32:0123abcd", .device = "A processor", .renderer = "cpu/adaptive/per-pixel/ellipse"},
          {1000, 640, 360, 2.5, 1.5}};
}

void read_text(const std::string& text) { read_sort_calibrations(as_bytes(text), "f.json"); }

}  // namespace

TEST_CASE("sort calibrations: what was added is read back to the last bit") {
  const TemporaryFolder place;
  SavedSortCalibration saved = usual();
  saved.key.device = "Quotes \" and \\ and \u00fc, 2 threads";
  saved.measured = {4'000'000'000, 1920, 65536, 1.0 / 3, 1.0 / 3 + 1e-15};
  add_sort_calibration(place / "f.json", saved);
  const std::vector<SavedSortCalibration> read = read_sort_calibrations(place / "f.json");
  REQUIRE(read.size() == 1);
  CHECK(read[0].key == saved.key);
  CHECK(read[0].measured == saved.measured);
}

TEST_CASE("sort calibrations: adding replaces the same case and a key finds its own sizes alone") {
  const TemporaryFolder place;
  const fs::path file = place / "f.json";
  std::vector<SavedSortCalibration> others(7, usual());
  others[0].key.scene = "crc32:0123abce", others[1].key.device = "Another", others[2].key.library = "0.0.9";
  others[3].key.renderer = "cpu/adaptive/per-pixel/opacity-box", others[4].measured.gaussians = 1001;
  others[5].measured.width = 641, others[6].measured.height = 361;
  for (const SavedSortCalibration& other : others) add_sort_calibration(file, other);
  SavedSortCalibration again = usual();
  again.measured.early_ms = 9;
  add_sort_calibration(file, again);
  add_sort_calibration(file, usual());
  CHECK(read_sort_calibrations(file).size() == 8);
  const std::vector<SortCalibration> found = find_sort_calibrations(file, usual().key);
  CHECK(found == std::vector{others[4].measured, others[5].measured, others[6].measured, usual().measured});
}

TEST_CASE("sort calibrations: a file that fits not or is not there is refused") {
  const TemporaryFolder place;
  const fs::path file = place / "f.json";
  CHECK_THROWS_AS(find_sort_calibrations(file, usual().key), std::system_error);
  add_sort_calibration(file, usual());
  const SortCalibrationKey key{usual().key.scene, "Another", usual().key.renderer};
  CHECK_THROWS_WITH_AS(
      find_sort_calibrations(file, key),
      (file.string() + ": expected a calibration of scene crc32:0123abcd by " +
       "cpu/adaptive/per-pixel/ellipse on 'Another', version " + std::string(version) + ", found 1 of others")
          .c_str(),
      std::runtime_error);
}

TEST_CASE("sort calibrations: damaged files and files of another kind are refused by place and left alone") {
  const TemporaryFolder place;
  const fs::path file = place / "f.json";
  add_sort_calibration(file, usual());
  const std::string good = content_of(file);
  check_every_truncation(good.substr(0, good.size() - 1), read_text);
  const std::size_t entry = good.rfind('{');
  const struct {
    const char *from, *to;
    std::size_t byte;
    const char* expected;
  } cases[] = {
      {"swiftgs-sort-calibrations", "another", 0, "the format swiftgs-sort-calibrations"},
      {"\"version\": 2", "\"version\": 1", 0, "version 2 of the format"},
      {"\"entries\"", "\"others\"", 0, "a file of sort calibrations with 'entries'"},
      {"\"scene\"", "\"screen\"", entry, "a sort calibration with 'scene'"},
      {"\"A processor\"", "5", entry, "'device' to be a string"},
      {"640", "65537", entry, "'width' to be a whole number from 1 to 65536"},
      {"1000", "0.5", entry, "'gaussians' to be a whole number from 1 to 4294967295"},
      {"2.5", "-2.5", entry, "'standard_ms' to be at least 0"},
      {"1.5", "null", entry, "a number in 'early_ms'"},
      {"  {", "3, {", entry - 2, "a sort calibration (a JSON object)"},
  };
  for (const auto& [from, to, byte, expected] : cases) {
    std::string text = good;
    place.write("f.json", text.replace(text.find(from), std::string(from).size(), to));
    const std::string message = file.string() + ": byte " + std::to_string(byte) + ": expected " + expected;
    CHECK(complaint([&] { read_sort_calibrations(file); }) == message);
    CHECK(complaint([&] { add_sort_calibration(file, usual()); }) == message);
    CHECK(content_of(file) == text);
  }
  CHECK_THROWS_AS(read_text("[]"), FormatError);
}

TEST_CASE("sort calibrations: the checksum has all that a sort depends on and no colours") {
  const Scene scene = make_builtin_scene(50);
  std::vector<Scene> others(5, scene);
  others[0].means[49].z += 1, others[1].scales[0].x *= 2, others[2].rotations[7].w += 0.5f;
  others[3].opacities[20] *= 0.5f, others[4].sh0[3].y += 1;
  for (std::size_t i = 0; i < 5; ++i)
    CHECK((geometry_checksum(others[i]) == geometry_checksum(scene)) == (i == 4));
}
