// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <system_error>

#include "scenes.hpp"
#include "sog_encoder.hpp"

namespace swiftgs::test::sog_streamed_test {

using nlohmann::json;

namespace {

json lod(int file, int offset, int count) { return {{"file", file}, {"offset", offset}, {"count", count}}; }

/// Three chunks: two of the finest level and one of the other. Leaves are not in the order of the chunks, and
/// one has nothing to show at level 1.
json lod_meta() {
  const json first = {{"lods", {{"0", lod(1, 0, 8)}, {"1", lod(2, 0, 4)}}}};
  const json second = {{"lods", {{"0", lod(0, 12, 8)}}}};
  const json third = {{"lods", {{"0", lod(0, 0, 12)}, {"1", lod(2, 4, 3)}}}};
  return {{"lodLevels", 2},
          {"environment", nullptr},
          {"filenames", {"0_0/meta.json", "0_1/meta.json", "1_0/meta.json"}},
          {"tree", {{"children", {first, {{"children", {second, third}}}}}}}};
}

/// A folder with those chunks, of degrees 1, 0 and 2, and an environment that `lod_meta` does not name.
struct Streamed {
  Streamed() { write("0_0", 20, 1), write("0_1", 8, 0), write("1_0", 7, 2), write("env", 5, 0); }
  void write(const std::string& chunk, std::size_t count, int degree) const {
    write_sog(place, "scan/" + chunk, encode_sog(some_scene(count, degree), 2));
  }
  SceneFile read(const json& meta, int level = 0) const {
    return read_scene(place.write("scan/lod-meta.json", meta.dump()), {.level = level});
  }
  Scene chunk(const std::string& name) const { return load_scene(place / ("scan/" + name + "/meta.json")); }
  std::string complaint_about(const json& meta, int level = 0) const {
    return complaint([&] { read(meta, level); });
  }

  TemporaryFolder place;
};

}  // namespace

TEST_CASE("streamed sog: a level is the Gaussians of its chunks in the order of the files") {
  const Streamed streamed;
  const SceneFile fine = streamed.read(lod_meta());
  CHECK(fine.format == "streamed SOG, level 0 of 2");
  CHECK(fine.stored == 28);
  CHECK(fine.notes.size() == 1);
  CHECK_NOTHROW(validate(fine.scene));
  CHECK(fine.scene.sh_degree == 1);
  const Scene first = streamed.chunk("0_0"), second = streamed.chunk("0_1");
  std::vector<vec3> means = first.means;
  means.insert(means.end(), second.means.begin(), second.means.end());
  CHECK(fine.scene.means == means);
  std::vector<float> sh = first.sh_rest;
  sh.resize(28 * 9);
  CHECK(fine.scene.sh_rest == sh);

  std::uintmax_t bytes = lod_meta().dump().size();
  for (const char* chunk : {"0_0", "0_1"})
    for (const auto& image :
         std::filesystem::directory_iterator(streamed.place / ("scan/" + std::string(chunk))))
      bytes += image.file_size();
  CHECK(fine.bytes == bytes);

  const SceneFile coarse = streamed.read(lod_meta(), 1);
  CHECK(coarse.format == "streamed SOG, level 1 of 2");
  CHECK(coarse.scene.sh_degree == 2);
  CHECK(coarse.scene.means == streamed.chunk("1_0").means);
  CHECK(coarse.scene.sh_rest == streamed.chunk("1_0").sh_rest);
  CHECK(load_scene(streamed.place / "scan", {.level = 1}).means == coarse.scene.means);
}

TEST_CASE("streamed sog: the environment follows every level and is noted") {
  const Streamed streamed;
  json meta = lod_meta();
  meta["environment"] = "env/meta.json";
  for (int level = 0; level < 2; ++level) {
    const SceneFile file = streamed.read(meta, level);
    CHECK(file.stored == (level == 0 ? 33 : 12));
    CHECK(std::vector<vec3>(file.scene.means.end() - 5, file.scene.means.end()) ==
          streamed.chunk("env").means);
    REQUIRE(file.notes.size() == 2);
    CHECK(contains(file.notes[1], "5 Gaussians of the environment"));
  }
}

TEST_CASE("streamed sog: Gaussians in no leaf are left out and counted") {
  const Streamed streamed;
  json meta = lod_meta();
  meta["tree"]["children"][1]["children"][0]["lods"]["0"]["count"] = 5;
  const SceneFile file = streamed.read(meta);
  CHECK(file.stored == 25);
  CHECK(contains(file.notes.at(1), "3 Gaussians"));
  CHECK(file.scene.means[17] == streamed.chunk("0_1").means[0]);
}

TEST_CASE("streamed sog: files that contradict themselves are refused") {
  const Streamed streamed;
  const auto with = [&](const std::string& place, const json& value) {
    json meta = lod_meta();
    meta[json::json_pointer(place)] = value;
    return streamed.complaint_about(meta);
  };
  CHECK(streamed.complaint_about(lod_meta()) == "");
  const std::string leaf = "/tree/children/0/lods/0";
  const struct {
    std::string place;
    json value;
    const char* expected;
  } cases[] = {{"/lodLevels", 0, "1 to 1000 levels"},
               {"/lodLevels", "2", "a number in 'lodLevels'"},
               {"/filenames", "x", "an array of files"},
               {"/filenames/1", 1, "names of files in the same folder"},
               {"/filenames/1", "../scan/0_1/meta.json", "names of files in the same folder"},
               {"/filenames/1", (streamed.place / "scan/0_1/meta.json").string(), "same folder"},
               {"/filenames/1", "./0_0//meta.json", "different files"},
               {"/environment", 7, "same folder"},
               {"/tree/children/0", 7, "nodes that are objects"},
               {leaf + "/file", 3, "a 'file' below 3"},
               {leaf + "/file", -1, "whole number 'file'"},
               {leaf + "/count", 9, "lie in its 8 Gaussians"},
               {leaf + "/count", ~std::uint64_t(0), "lie in its 8 Gaussians"},
               {leaf + "/offset", 9, "lie in its 8 Gaussians"},
               {"/tree/children/1/children/0/lods/0/offset", 11, "do not overlap"}};
  for (const auto& [place, value, expected] : cases)
    CHECK_MESSAGE(contains(with(place, value), expected), place);
  CHECK_THROWS_AS(with("/filenames/1", "0_7/meta.json"), std::system_error);
}

TEST_CASE("streamed sog: chunks cannot share images to be more than their bytes warrant") {
  const TemporaryFolder place;
  constexpr std::size_t count = 40'000;
  const SogParts parts = encode_sog(some_scene(count, 0), 1);
  const auto files = sog_files(parts);
  const auto scan = [&](const std::vector<std::string>& chunks) {
    json meta = {{"lodLevels", 1}, {"filenames", chunks}, {"tree", {{"children", json::array()}}}};
    for (std::size_t i = 0; i < chunks.size(); ++i)
      meta["tree"]["children"].push_back({{"lods", {{"0", lod(int(i), 0, int(count))}}}});
    return place.write("scan/lod-meta.json", meta.dump());
  };
  json other = parts.meta;
  for (const char* part : {"means", "scales", "quats", "sh0"})
    for (json& name : other[part]["files"]) name = "link_" + name.get<std::string>();
  for (const auto& [name, content] : files) {
    place.write("scan/" + name, content);
    std::filesystem::create_symlink(name, place / ("scan/link_" + name));
  }
  place.write("scan/other.json", parts.meta.dump());
  place.write("scan/links.json", other.dump());
  CHECK(read_scene(scan({"meta.json"})).scene.size() == count);
  CHECK(read_scene(scan({"links.json"})).scene.size() == count);
  for (const char* second : {"other.json", "links.json", "link_meta.json"}) {
    CAPTURE(second);
    const std::filesystem::path path = scan({"meta.json", second});
    CHECK(contains(complaint([&] { read_scene(path); }), "bytes beside those that hold others"));
  }
}

TEST_CASE("streamed sog: a level that is not there is refused and so is a file in memory") {
  const Streamed streamed;
  const std::string text = "  " + lod_meta().dump();
  const auto path = streamed.place.write("scan/lod-meta.json", text);
  const std::string place = path.string() + ": byte " + std::to_string(text.find("\"lodLevels\":") + 12);
  CHECK(complaint([&] { read_scene(path, {.level = 2}); }) ==
        place + ": expected level 2 of detail, found 2 levels, 0 to 1");
  CHECK_THROWS_WITH_AS(read_scene(path, {.level = -1}),
                       (path.string() + ": level is -1, expected 0, the finest detail, or more").c_str(),
                       std::invalid_argument);
  CHECK(contains(complaint_about(text, "lod-meta.json"), "found JSON of a SOG in memory"));
}

}  // namespace swiftgs::test::sog_streamed_test
