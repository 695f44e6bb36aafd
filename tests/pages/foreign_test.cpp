// SPDX-License-Identifier: Apache-2.0

// Scenes with levels of detail that other programs wrote, drawn as pages.
#include <atomic>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/renderer.hpp>
#include <swiftgs/serial.hpp>

#include "io/gltf_encoder.hpp"
#include "io/sog_encoder.hpp"
#include "io/spz_encoder.hpp"

namespace swiftgs::test::foreign_pages {
namespace {

using nlohmann::json;

json array(json::initializer_list_t items) { return json::array(items); }

/// Gaussians of a complete cut by a camera that sees all, and its first number's name.
Cut cut_of(const PagedScene& pages, double pixels) {
  static Renderer<Serial> renderer;
  PagePool<Serial> pool(renderer.backend(), pages);
  const ChunkBounds& bounds = pages.pages()[pages.root()].bounds;
  const dvec3 low(bounds.low[0], bounds.low[1], bounds.low[2]),
      high(bounds.high[0], bounds.high[1], bounds.high[2]);
  const Camera camera =
      look_at(low - 3.0 * (high - low) - dvec3(1), 0.5 * (low + high), {0, 0, 1}, 1, 64, 48);
  std::vector<View> views;
  make_views({&camera, 1}, {}, views);
  Cut cut = pool.cut({views.data(), views.size()}, {.pixels = pixels});
  pool.wait(cut);
  CHECK(cut.missing() == 0);
  return cut;
}

json lod(int file, int offset, int count) { return {{"file", file}, {"offset", offset}, {"count", count}}; }
json bound(double low, double high) { return {{"min", {low, low, low}}, {"max", {high, high, high}}}; }

/// Two leaves of three levels and of one, and an environment.
struct Streamed {
  Streamed() { write("0_0", 60), write("1_0", 20), write("2_0", 7), write("env", 5); }
  void write(const std::string& chunk, std::size_t count) const {
    write_sog(place, "scan/" + chunk, encode_sog(some_scene(count, 1), 2));
  }
  json meta() const {
    const json first = {{"bound", bound(-2, 2)},
                        {"lods", {{"0", lod(0, 0, 40)}, {"1", lod(1, 0, 20)}, {"2", lod(2, 0, 7)}}}};
    const json second = {{"bound", bound(-3, 2)}, {"lods", {{"0", lod(0, 40, 20)}}}};
    return {{"lodLevels", 3},
            {"environment", "env/meta.json"},
            {"filenames", {"0_0/meta.json", "1_0/meta.json", "2_0/meta.json"}},
            {"tree", {{"bound", bound(-3, 2)}, {"children", {first, second}}}}};
  }
  PagedScene open(const json& meta) const {
    return open_pages(place.write("scan/lod-meta.json", meta.dump()));
  }

  TemporaryFolder place;
};

TEST_CASE("pages: a streamed SOG is drawn by its levels") {
  const Streamed streamed;
  const PagedScene pages = streamed.open(streamed.meta());
  CHECK(pages.gaussians() == 65);
  CHECK(pages.pages().size == 6);
  CHECK(pages.read(pages.root()).scene.size() == 7 + 20 + 5);
  CHECK(read_leaves(pages).means == load_scene(streamed.place / "scan/lod-meta.json").means);
  CHECK(cut_of(pages, 0).splats() == 65);
  CHECK(cut_of(pages, 1e9).splats() == 32);
  const Page coarse = pages.pages()[pages.root()];
  CHECK(coarse.errors[0] == float(4 / std::sqrt(7.0)));  // side of the first leaf, whose level has 7
  CHECK(pages.pages()[1].errors[0] == float(4 / std::sqrt(20.0)));
}

TEST_CASE("pages: threads read pages of the same files at once") {
  const Streamed streamed;
  const PagedScene alone = streamed.open(streamed.meta());
  json broken = streamed.meta();
  broken["tree"]["children"][0]["lods"]["0"]["offset"] = 50;
  for (int round = 0; round < 10; ++round) {  // each begins with no file decoded but the root's
    const PagedScene pages = streamed.open(round % 2 == 0 ? streamed.meta() : broken);
    std::atomic<int> refused = 0, wrong = 0;
    std::vector<std::thread> threads;
    for (int k = 0; k < 4; ++k)
      threads.emplace_back([&] {
        for (std::uint32_t page = 0; page < pages.pages().size; ++page) try {
            wrong += pages.read(page).scene.means != alone.read(page).scene.means;
          } catch (const FormatError&) {
            ++refused;
          }
      });
    for (std::thread& thread : threads) thread.join();
    CHECK(wrong == 0);
    CHECK(refused == (round % 2 == 0 ? 0 : 4));
  }
  std::filesystem::remove_all(streamed.place / "scan/0_0");
  const PagedScene lacking = streamed.open(streamed.meta());
  std::atomic<int> failed = 0;
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k)
    threads.emplace_back([&] {
      for (int i = 0; i < 5; ++i) try {
          lacking.read(0);
        } catch (const FileError&) {
          ++failed;
        }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(failed == 20);
}

TEST_CASE("pages: a streamed SOG that is not one is refused") {
  const Streamed streamed;
  const auto refused = [&](const json& meta, const char* expected) {
    CHECK_THROWS_WITH_AS(streamed.open(meta), doctest::Contains(expected), FormatError);
  };
  json meta = streamed.meta();
  meta["filenames"][0] = "../0_0/meta.json";
  refused(meta, "files in the same folder or below it, found '../0_0/meta.json'");
  meta = streamed.meta(), meta["tree"]["children"][0].erase("bound");
  refused(meta, "leaves with a bound");
  meta = streamed.meta(), meta["tree"]["children"][0]["lods"]["0"]["file"] = 7;
  refused(meta, "a 'file' of filenames");
  meta = streamed.meta(), meta["tree"]["children"] = array({});
  refused(meta, "leaves with levels of detail");
  meta = streamed.meta();
  for (int level = 0; level < 9999; ++level)
    meta["tree"]["children"][0]["lods"][std::to_string(level)] = lod(0, 0, 1);
  refused(meta, "at most 64 levels of pages in each other");
  meta = streamed.meta(), meta["tree"]["children"][0]["lods"]["0"]["offset"] = 50;
  const PagedScene pages = streamed.open(meta);
  CHECK_THROWS_WITH_AS(pages.read(0), doctest::Contains("90 Gaussians or more"), FormatError);
}

json box(double half) { return {{"box", {0, 0, 0, half, 0, 0, 0, half, 0, 0, 0, half}}}; }
json tile(const char* uri, double error, json children = json::array()) {
  json tile = {{"boundingVolume", box(5)}, {"geometricError", error}, {"children", std::move(children)}};
  if (uri) tile["content"] = {{"uri", uri}};
  return tile;
}

struct Tileset {
  Tileset() {
    place.write("t/a.glb", glb(encode_gltf(some_scene(3, 0))));
    place.write("t/b.glb", glb(encode_gltf(some_scene(4, 1))));
    GltfParts parts =
        gltf_with_spz(gzip_spz(encode_spz(some_scene(5, 2), 2)), "KHR_gaussian_splatting_compression_spz_2");
    for (json& accessor : parts.root["accessors"]) accessor["count"] = 5;
    place.write("t/c.glb", glb(parts));
    place.write("t/below/tileset.json",
                json({{"asset", {{"version", "1.1"}}}, {"root", tile("d.gltf", 0)}}).dump());
    place.write("t/below/d.gltf", gltf(encode_gltf(some_scene(6, 3))));
  }
  PagedScene open(const json& root) const {
    return open_pages(
        place.write("t/tileset.json", json({{"asset", {{"version", "1.1"}}}, {"root", root}}).dump()));
  }
  TemporaryFolder place;
};

TEST_CASE("pages: 3D Tiles are drawn by replacing and adding tiles") {
  const Tileset tiles;
  json b = tile("b.glb", 2, array({tile("c.glb", 0)}));
  b["refine"] = "ADD";
  json root = tile("a.glb", 9, array({b, tile("below/tileset.json", 0)}));
  root["refine"] = "REPLACE";
  const PagedScene pages = tiles.open(root);
  CHECK(pages.gaussians() == 4 + 5 + 6);
  CHECK(pages.read(pages.root()).scene.size() == 3);
  CHECK(pages.pages()[pages.root()].errors[0] == 9);
  CHECK(cut_of(pages, 0).splats() == 15);
  CHECK(cut_of(pages, 1e9).splats() == 3);
  CHECK(read_leaves(pages).sh_degree == 3);

  // A tile without content shows what is below it.
  const PagedScene empty = tiles.open(tile(nullptr, 9, array({tile("a.glb", 0), tile("b.glb", 0)})));
  CHECK(empty.read(empty.root()).scene.size() == 7);
  CHECK(cut_of(empty, 1e9).splats() == 7);

  const std::filesystem::path renamed =
      tiles.place.write("t/city.json", content_of(tiles.place / "t/tileset.json"));
  CHECK(is_page_file(renamed));
  CHECK(open_pages(renamed).gaussians() == empty.gaussians());
  CHECK_FALSE(is_page_file(tiles.place.write("t/cameras.json", R"([{"img_name": "root"}])")));
}

TEST_CASE("pages: content of tiles is moved from glTF's axes to those of the tileset") {
  const Tileset tiles;
  json root = tile("a.glb", 9);
  root["transform"] = {0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 6400000, 0, 70, 1};
  root["boundingVolume"] = {{"sphere", {0, 0, 0, 4}}};
  const PagedScene pages = tiles.open(root);
  CHECK(pages.origin() == dvec3(6400000, 0, 70));
  const Scene found = pages.read(0).scene, before = load_scene(tiles.place / "t/a.glb");
  CHECK(found.origin == pages.origin());
  for (std::size_t i = 0; i < 3; ++i) {
    const vec3 p = before.means[i];  // glTF's (-x, -y, z), whose y points up
    const vec3 in_tile(-p.x, -p.z, -p.y);
    const vec3 expected(-2 * in_tile.y, 2 * in_tile.x, 2 * in_tile.z);
    for (int k = 0; k < 3; ++k) CHECK(found.means[i][k] == doctest::Approx(expected[k]).epsilon(1e-5));
  }
  CHECK(pages.pages()[0].bounds.low[2] == doctest::Approx(-8));
}

TEST_CASE("pages: tilesets that cannot be drawn are refused by name") {
  const Tileset tiles;
  const auto refused = [&](const json& root, const char* expected) {
    CHECK_THROWS_WITH_AS(tiles.open(root), doctest::Contains(expected), FormatError);
  };
  json root = tile("a.glb", 1);
  root["implicitTiling"] = json::object();
  refused(root, "explicit tiling, found implicit tiling");
  root = tile("a.glb", 1), root.erase("geometricError");
  refused(root, "a geometricError");
  root = tile("a.glb", 1), root["boundingVolume"] = {{"region", {0, 0, 1, 1, 0, 9}}};
  refused(root, "a boundingVolume of box or sphere, found a region");
  root = tile("a.glb", 1), root["content"]["uri"] = 7;
  refused(root, "members of the kinds that the format has");
  root = tile("a.glb", 1), root["refine"] = "MORE";
  refused(root, "ADD or REPLACE");
  root = tile("a.glb", 1), root["transform"] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  refused(root, "a matrix that does not mirror");
  refused(tile("https://a.org/a.glb", 1), "found 'https://a.org/a.glb'");
  refused(tile("%2e%2e/a.glb", 1), "found '%2e%2e/a.glb'");
  refused(tile(nullptr, 1), "Gaussians");
  tiles.place.write("t/mesh.gltf", R"({"asset": {"version": "2.0"}, "meshes": []})");
  refused(tile("mesh.gltf", 1), "a glTF with Gaussians");
  tiles.place.write("t/x.b3dm", "b3dm");
  refused(tile("x.b3dm", 1), "x.b3dm: byte 0: expected a glTF, found content of b3dm");
  tiles.place.write("t/huge.gltf", R"({"accessors": [{"count": 4294967297}], "nodes": [{"mesh": 0}], "meshes":
    [{"primitives": [{"attributes": {"POSITION": 0}, "extensions": {"KHR_gaussian_splatting": {}}}]}]})");
  refused(tile("huge.gltf", 1), "huge.gltf: byte 0: expected fewer than 2^32 Gaussians");
  CHECK_THROWS_AS(tiles.open(tile("none.glb", 1)), FileError);
  REQUIRE(::mkfifo((tiles.place / "t/pipe.glb").c_str(), 0600) == 0);
  CHECK_THROWS_AS(tiles.open(tile("pipe.glb", 1)), FileError);
}

TEST_CASE("pages: tilesets that hold themselves or are deep or endless are refused by their file") {
  const Tileset tiles;
  const auto refused = [&](const json& root, const char* expected) {
    CHECK_THROWS_WITH_AS(tiles.open(root), doctest::Contains(expected), FormatError);
  };
  const auto write = [&](const std::string& name, const json& root) {
    tiles.place.write("t/" + name, json({{"root", root}}).dump());
  };
  write("a.json", tile("b.json", 1)), write("b.json", tile("./%61.json", 1));
  refused(tile("a.json", 1), "a.json: byte 0: expected a tileset that does not hold itself");
  json deep = tile("a.glb", 0);
  for (int level = 0; level < 65; ++level) deep = tile(nullptr, 1, array({deep}));
  refused(deep, "at most 64 tiles in each other");
  json broken = tile("a.glb", 1);
  broken["content"]["uri"] = 7;
  write("broken.json", broken);
  refused(tile("broken.json", 1), "broken.json: byte 0: expected members of the kinds that the format has");
  json endless = tile("a.glb", 1);
  endless["boundingVolume"] = {{"sphere", {1e308, 1e308, 1e308, 1e308}}};
  refused(endless, "finite bounds");

  const std::string nested = std::string(300'000, '[') + std::string(300'000, ']');
  const std::string root = R"({"root": {"geometricError": 1, "extensions": )" + nested + "}}";
  CHECK_THROWS_WITH_AS(open_pages(tiles.place.write("t/tileset.json", root)),
                       doctest::Contains("at most 256 arrays and objects in each other"), FormatError);
  tiles.place.write("t/deep.gltf", R"({"meshes": )" + nested + "}");
  refused(tile("deep.gltf", 1), "deep.gltf: byte 266: expected at most 256 arrays and objects in each other");
  // Tilesets that name the next one twice are 2^20 tilesets.
  for (int k = 0; k < 20; ++k) {
    const std::string next = std::to_string(k + 1) + ".json";
    write(std::to_string(k) + ".json",
          tile(nullptr, 1, array({tile(next.c_str(), 1), tile(next.c_str(), 1)})));
  }
  write("20.json", tile("a.glb", 1));
  refused(tile("0.json", 1), "at most 65536 tilesets");
}

TEST_CASE("pages: tiles whose files have other rendering models are refused when they are read") {
  const Tileset tiles;
  GltfParts other = encode_gltf(some_scene(4, 1));
  other.root["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"]["sortingMethod"] =
      "zDepth";
  tiles.place.write("t/b.glb", glb(other));
  const PagedScene pages = tiles.open(tile("a.glb", 9, array({tile("b.glb", 0)})));
  CHECK(pages.read(pages.root()).scene.model == pages.model());
  CHECK_THROWS_WITH_AS(pages.read(0), doctest::Contains("b.glb: byte 0: expected the rendering model"),
                       FormatError);
}

}  // namespace
}  // namespace swiftgs::test::foreign_pages
