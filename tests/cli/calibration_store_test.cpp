// SPDX-License-Identifier: Apache-2.0
#include "calibration_store.hpp"

#include <filesystem>
#include <stdexcept>

#include <doctest/doctest.h>

#include "support/files.hpp"

using namespace swiftgs;
using swiftgs::cli::CalibrationStore;
using swiftgs::test::content_of;
using swiftgs::test::TemporaryFolder;

namespace {

SavedSortCalibration at_width(int width) {
  return {{.scene = "crc32:0123abcd", .device = "A processor", .backend = "cpu", .bounds = "ellipse"},
          {1000, width, 360, 2.5, 1.5},
          7};
}

std::size_t entries_in(const std::filesystem::path& file) { return read_sort_calibrations(file).size(); }

}  // namespace

TEST_CASE("calibration store: the first file that can be written takes all") {
  const TemporaryFolder place;
  CalibrationStore store({place / "a.json", place / "deep/cache/b.json"});
  store.add(at_width(1)), store.add(at_width(2));
  CHECK(entries_in(place / "a.json") == 2);
  CHECK_FALSE(std::filesystem::exists(place / "deep"));
  CHECK(store.summary() == (place / "a.json").string() + ": 2 calibrations");
}

TEST_CASE("calibration store: where the first cannot be written the next takes all and says why") {
  const TemporaryFolder place;
  place.write("a.json", "a file of somebody else");
  CalibrationStore store({place / "a.json", place / "deep/cache/b.json"});
  store.add(at_width(1));
  CHECK(content_of(place / "a.json") == "a file of somebody else");
  CHECK(entries_in(place / "deep/cache/b.json") == 1);
  CHECK(store.summary().starts_with((place / "deep/cache/b.json").string() +
                                    ": 1 calibration, as another place cannot be written: " +
                                    (place / "a.json").string() + ": byte 0: expected "));
}

TEST_CASE("calibration store: no place at all is an error before anything is measured") {
  const TemporaryFolder place;
  std::filesystem::create_directory(place / "a.json");
  place.write("file", "");
  CHECK_THROWS_WITH_AS(CalibrationStore({place / "a.json", place / "file/b.json"}),
                       ((place / "a.json").string() + ": Is a directory; " +
                        (place / "file/b.json").string() + ": Not a directory; expected --out")
                           .c_str(),
                       std::runtime_error);
}

TEST_CASE("calibration store: what is measured outlives its place") {
  const TemporaryFolder place;
  std::filesystem::create_directory(place / "first");
  CalibrationStore store({place / "first/a.json", place / "second/b.json"});
  store.add(at_width(1));
  std::filesystem::remove_all(place / "first");
  place.write("first", "");
  store.add(at_width(2));
  CHECK(entries_in(place / "second/b.json") == 1);
  std::filesystem::remove_all(place / "second");
  place.write("second", "");
  CHECK_NOTHROW(store.add(at_width(3)));
  CHECK_NOTHROW(store.add(at_width(4)));
  CHECK(store.summary().starts_with("not all calibrations were kept: "));
}
