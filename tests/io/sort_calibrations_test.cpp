// SPDX-License-Identifier: Apache-2.0
#include <atomic>
#include <cstdlib>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <zlib.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/io/sort_calibrations.hpp>

#include "io/files.hpp"

using namespace swiftgs;
using namespace swiftgs::test;
namespace fs = std::filesystem;

namespace {

SortCalibrationKey usual_key() {
  return {
      .scene = "crc32:0123abcd", .device = "A processor, 2 threads", .backend = "cpu", .bounds = "ellipse"};
}

SavedSortCalibration usual() { return {usual_key(), {1000, 640, 360, 2.5, 1.5}, 7}; }

/// The file that `usual()` makes, with a part of it replaced.
std::string text_with(const std::string& from, const std::string& to) {
  const TemporaryFolder place;
  add_sort_calibrations(place / "usual.json", {usual()});
  std::string text = content_of(place / "usual.json");
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

std::size_t files_in(const fs::path& folder) {
  return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

uLong zlib_crc(uLong before, const void* data, std::size_t bytes) {
  return crc32(before, static_cast<const Bytef*>(data), uInt(bytes));
}

template <class T>
uLong zlib_crc(uLong before, const std::vector<T>& array) {
  return zlib_crc(before, array.data(), array.size() * sizeof(T));
}

/// An environment variable for a while; without `value` there is none.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    set(value);
  }
  ~Variable() { set(before_ ? before_->c_str() : nullptr); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  void set(const char* value) const {
    if (value)
      ::setenv(name_, value, 1);
    else
      ::unsetenv(name_);
  }

  const char* name_;
  std::optional<std::string> before_;
};

}  // namespace

TEST_CASE("sort calibrations: what was added is read back to the last bit") {
  const TemporaryFolder place;
  SavedSortCalibration saved = usual();
  saved.key.device = "Quotes \" and \\ and \u00fc, 2 threads";
  saved.measured = {4'000'000'000, 1920, 65536, 1.0 / 3, 1.0 / 3 + 1e-15};
  CHECK(add_sort_calibrations(place / "f.json", {saved}) == 0);
  const std::vector<SavedSortCalibration> read = read_sort_calibrations(place / "f.json");
  REQUIRE(read.size() == 1);
  CHECK(read[0].key == saved.key);
  CHECK(read[0].key.library == version);
  CHECK(read[0].measured.gaussians == saved.measured.gaussians);
  CHECK(read[0].measured.width == 1920);
  CHECK(read[0].measured.height == 65536);
  CHECK(read[0].measured.standard_ms == saved.measured.standard_ms);
  CHECK(read[0].measured.early_ms == saved.measured.early_ms);
  CHECK(read[0].views == 7);
  CHECK_FALSE(read[0].measured.prefers_early());
  CHECK(files_in(place.path()) == 1);
}

TEST_CASE("sort calibrations: adding replaces the same case and leaves every other") {
  const TemporaryFolder place;
  const fs::path file = place / "f.json";
  std::vector<SavedSortCalibration> others(8, usual());
  others[0].key.scene = "crc32:0123abce", others[1].key.device = "Another", others[2].key.backend = "cuda";
  others[3].key.bounds = "opacity-box", others[4].key.library = "0.0.9", others[5].measured.gaussians = 1001;
  others[6].measured.width = 641, others[7].measured.height = 361;
  CHECK(add_sort_calibrations(file, others) == 0);
  CHECK(add_sort_calibrations(file, {usual()}) == 8);
  SavedSortCalibration again = usual();
  again.measured.early_ms = 9, again.views = 3;
  CHECK(add_sort_calibrations(file, {again}) == 8);
  const std::vector<SavedSortCalibration> read = read_sort_calibrations(file);
  REQUIRE(read.size() == 9);
  for (std::size_t i = 0; i < 8; ++i) CHECK(read[i].measured.early_ms == 1.5);
  CHECK(read[8].measured.early_ms == 9);
  CHECK(read[8].views == 3);
}

TEST_CASE("sort calibrations: a key finds its own sizes and nothing else") {
  const TemporaryFolder place;
  const fs::path file = place / "f.json";
  std::vector<SavedSortCalibration> saved(3, usual());
  saved[1].measured.width = 1280, saved[2].key.bounds = "opacity-box";
  add_sort_calibrations(file, saved);
  const FoundSortCalibrations found = find_sort_calibrations(file, usual_key());
  CHECK(found.why_none == "");
  REQUIRE(found.calibrations.size() == 2);
  CHECK(found.calibrations[0].width == 640);
  CHECK(found.calibrations[1].width == 1280);
}

TEST_CASE("sort calibrations: what is stale is not found and says why in one line") {
  const TemporaryFolder place;
  const fs::path file = place / "f.json";
  SavedSortCalibration saved = usual();
  saved.key.device = "Two\nlines";
  saved.key.library = "0.0.9";
  add_sort_calibrations(file, {saved});
  const std::string name = file.string() + " ";
  SortCalibrationKey key = saved.key;
  CHECK(find_sort_calibrations(file, key).calibrations.size() == 1);

  key.bounds = "opacity-box";
  CHECK(find_sort_calibrations(file, key).why_none == name + "holds no calibration of cpu with opacity-box");
  key.bounds = "ellipse", key.backend = "serial";
  CHECK(find_sort_calibrations(file, key).why_none == name + "holds no calibration of serial with ellipse");
  key.device = "Another";
  CHECK(find_sort_calibrations(file, key).why_none ==
        name + "was calibrated on 'Two lines', and this is 'Another'");
  key.library = "0.1.0";
  CHECK(find_sort_calibrations(file, key).why_none ==
        name + "was calibrated by version 0.0.9, and this is 0.1.0");
  key.scene = "crc32:00000000";
  CHECK(find_sort_calibrations(file, key).why_none == name + "was calibrated for other content of the scene");
  CHECK(find_sort_calibrations(file, key).calibrations.empty());
  add_sort_calibrations(place / "none.json", {});
  CHECK(find_sort_calibrations(place / "none.json", key).why_none ==
        (place / "none.json").string() + " holds no calibration");
}

TEST_CASE("sort calibrations: no file is nothing to speak of and a folder is no file") {
  const TemporaryFolder place;
  CHECK(find_sort_calibrations(place / "f.json", usual_key()).why_none == "");
  CHECK(contains(find_sort_calibrations(place.path(), usual_key()).why_none, "directory"));
  CHECK_THROWS_AS(read_sort_calibrations(place / "f.json"), std::system_error);
}

TEST_CASE("sort calibrations: a part of a file is refused and found nothing in and written anew") {
  const TemporaryFolder place;
  add_sort_calibrations(place / "f.json", {usual()});
  std::string content = content_of(place / "f.json");
  content.pop_back();  // the line's end says nothing
  check_every_truncation(content,
                         [](const std::string& text) { read_sort_calibrations(as_bytes(text), "f.json"); });
  const fs::path cut = place.write("cut.json", content.substr(0, content.size() - 4));
  CHECK(contains(find_sort_calibrations(cut, usual_key()).why_none, "expected valid JSON"));
  CHECK(add_sort_calibrations(cut, {usual()}) == 0);
  CHECK(find_sort_calibrations(cut, usual_key()).calibrations.size() == 1);
  const fs::path empty = place.write("empty.json", "");
  CHECK(add_sort_calibrations(empty, {usual()}) == 0);
  CHECK(find_sort_calibrations(empty, usual_key()).calibrations.size() == 1);
}

TEST_CASE("sort calibrations: a file of another kind is refused and left alone") {
  const TemporaryFolder place;
  const fs::path file = place.write("garden.spz", "not JSON at all");
  CHECK(complaint([&] { add_sort_calibrations(file, {usual()}); }) ==
        file.string() + ": byte 0: expected a file of sort calibrations, or none");
  CHECK(content_of(file) == "not JSON at all");
  CHECK(files_in(place.path()) == 1);
}

TEST_CASE("sort calibrations: members that make no sense are refused by name") {
  const char* cases[][3] = {
      {"swiftgs-sort-calibrations", "another", "the format swiftgs-sort-calibrations"},
      {"\"version\": 1", "\"version\": 2", "version 1 of the format"},
      {"\"entries\"", "\"others\"", "an array 'entries'"},
      {"\"scene\"", "\"screen\"", "entry 0 with a string 'scene'"},
      {"\"cpu\"", "5", "entry 0 with a string 'backend'"},
      {"\"width\":640", "\"width\":0", "'width' from 1 to 65536"},
      {"\"width\":640", "\"width\":65537", "'width' from 1 to 65536"},
      {"\"height\":360", "\"height\":-360", "'height' from 1 to 65536"},
      {"\"gaussians\":1000", "\"gaussians\":1.5", "'gaussians' from 1 to 4294967295"},
      {"\"views\":7", "\"views\":\"7\"", "'views' from 1 to"},
      {"2.5", "-2.5", "'standard_ms' of at least 0"},
      {"1.5", "null", "'early_ms' of at least 0"},
      {"2.5", "1e999", "numbers that a double can hold"},
      {"\n {", "\n 3, {", "entry 0 to be an object"},
  };
  CHECK(complaint([] { read_sort_calibrations(as_bytes(text_with("2.5", "2.5")), "f.json"); }) == "");
  for (const auto& [from, to, expected] : cases) {
    const std::string text = text_with(from, to);
    const std::string message = complaint([&] { read_sort_calibrations(as_bytes(text), "f.json"); });
    CAPTURE(message);
    CHECK(message.starts_with("f.json: byte "));
    CHECK(contains(message, expected));
  }
  for (const char* text : {"[]", "3", "null", "{}", "[1, {\"format\": 1}]"})
    CHECK(contains(complaint([&] { read_sort_calibrations(as_bytes(text), "f.json"); }), "an object with"));
}

TEST_CASE("sort calibrations: writers at the same time lose nothing and readers never see a part") {
  const TemporaryFolder place;
  const fs::path file = place / "f.json";
  add_sort_calibrations(file, {usual()});
  std::atomic<bool> written{false};
  std::atomic<int> damaged{0}, reads{0};
  std::thread reader([&] {
    while (!written) {
      if (find_sort_calibrations(file, usual_key()).calibrations.size() != 1) ++damaged;
      ++reads;
    }
  });
  std::vector<std::thread> writers;
  for (int writer = 0; writer < 6; ++writer)
    writers.emplace_back([&, writer] {
      for (int i = 0; i < 5; ++i) {
        SavedSortCalibration saved = usual();
        saved.key.device = "device " + std::to_string(5 * writer + i);
        add_sort_calibrations(file, {saved});
      }
    });
  for (std::thread& writer : writers) writer.join();
  written = true;
  reader.join();
  CHECK(damaged == 0);
  CHECK(reads > 0);
  CHECK(read_sort_calibrations(file).size() == 31);
  CHECK(files_in(place.path()) == 1);
}

TEST_CASE("sort calibrations: the checksum is the CRC-32 of the content and not of the file") {
  const Scene scene = make_builtin_scene(100'000);  // enough for several threads
  const unsigned char properties[] = {3, 0};
  uLong crc = zlib_crc(crc32(0, nullptr, 0), properties, 2);
  crc = zlib_crc(zlib_crc(zlib_crc(crc, scene.means), scene.scales), scene.rotations);
  crc = zlib_crc(zlib_crc(zlib_crc(crc, scene.opacities), scene.sh0), scene.sh_rest);
  char expected[32];
  std::snprintf(expected, sizeof(expected), "crc32:%08lx", crc);
  CHECK(scene_checksum(scene) == expected);

  const TemporaryFolder place;
  write_scene(place / "a.ply", make_builtin_scene(100));
  fs::copy_file(place / "a.ply", place / "b.ply");
  CHECK(scene_checksum(load_scene(place / "a.ply")) == scene_checksum(load_scene(place / "b.ply")));
}

TEST_CASE("sort calibrations: every part of a scene is in its checksum") {
  const Scene scene = make_builtin_scene(50);
  std::vector<Scene> others(8, scene);
  others[0].means[49].z += 1, others[1].scales[0].x *= 2, others[2].rotations[7].w += 0.5f;
  others[3].opacities[20] *= 0.5f, others[4].sh0[3].y += 1, others[5].sh_rest.back() += 1;
  others[6].antialiased = !scene.antialiased, others[7].sh_degree = 2;
  for (const Scene& other : others) CHECK(scene_checksum(other) != scene_checksum(scene));
}

TEST_CASE("sort calibrations: places are beside the scene and in the user's cache") {
  const TemporaryFolder place;
  const auto places_with = [&](const char* cache, const char* home, const fs::path& scene) {
    const Variable a("XDG_CACHE_HOME", cache), b("HOME", home);
    return sort_calibrations_places(scene);
  };
  const fs::path scene = place / "garden.spz";
  const auto of_cache = places_with("/somewhere/cache", "/home/a", scene);
  REQUIRE(of_cache.size() == 2);
  CHECK(of_cache[0] == sort_calibrations_beside(scene));
  CHECK(of_cache[1].parent_path() == "/somewhere/cache/swiftgs");
  CHECK(of_cache[1].filename().string().starts_with("garden.spz-"));
  CHECK(of_cache[1].filename().string().ends_with(".sort.json"));
  CHECK(places_with(nullptr, "/home/a", scene)[1].parent_path() == "/home/a/.cache/swiftgs");
  CHECK(places_with("", "/home/a", scene)[1].parent_path() == "/home/a/.cache/swiftgs");
  CHECK(places_with("relative", "/home/a", scene)[1].parent_path() == "/home/a/.cache/swiftgs");
  CHECK(places_with(nullptr, nullptr, scene).size() == 1);
  // One scene has one place whatever way leads to it, and another scene another.
  CHECK(places_with("/c", nullptr, place / "." / "garden.spz")[1] == places_with("/c", nullptr, scene)[1]);
  CHECK(places_with("/c", nullptr, place / "other" / "garden.spz")[1] !=
        places_with("/c", nullptr, scene)[1]);
}

TEST_CASE("sort calibrations: of several files the first counts at each size") {
  const TemporaryFolder place;
  const std::vector<fs::path> files{place / "a.json", place / "b.json"};
  CHECK(find_sort_calibrations(files, usual_key()).why_none == "");
  SavedSortCalibration other = usual();
  other.measured.early_ms = 99;
  SavedSortCalibration wider = usual();
  wider.measured.width = 1280;
  add_sort_calibrations(files[1], {other, wider});
  REQUIRE(find_sort_calibrations(files, usual_key()).calibrations.size() == 2);
  add_sort_calibrations(files[0], {usual()});
  const FoundSortCalibrations found = find_sort_calibrations(files, usual_key());
  REQUIRE(found.calibrations.size() == 2);
  CHECK(found.calibrations[0].early_ms == 1.5);
  CHECK(found.calibrations[1].width == 1280);
  // A damaged file hides no other.
  place.write("a.json", "damaged");
  CHECK(find_sort_calibrations(files, usual_key()).calibrations.size() == 2);
  CHECK(find_sort_calibrations(files, usual_key()).why_none == "");
  place.write("b.json", "damaged too");
  CHECK(find_sort_calibrations(files, usual_key()).why_none.starts_with(files[0].string()));
}
