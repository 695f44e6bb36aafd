// SPDX-License-Identifier: Apache-2.0

// 3D Tiles 1.1 with explicit tiling, whose content is glTF with Gaussians.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <glm/matrix.hpp>

#include <swiftgs/error.hpp>
#include <swiftgs/scene.hpp>

#include "file_pages.hpp"

namespace swiftgs::pages {
namespace {

using nlohmann::json;

/// Tilesets of tilesets, and tiles of tiles.
constexpr int most_levels = 64;
/// One may name others, or itself, again and again.
constexpr int most_tilesets = 1 << 16;

/// How many Gaussians a glTF has, and of which degree.
struct Holds {
  std::size_t count = 0;
  int sh_degree = 0;
};

/// The JSON of a glTF: all of a text file, the first chunk of a binary one.
json head_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 20> head{};
  file.read(head.data(), head.size());
  if (!file || std::memcmp(head.data(), "glTF", 4) != 0) return FilePages::parse(path);
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, head.data() + 12, sizeof bytes);
  std::error_code error;
  if (bytes > std::filesystem::file_size(path, error))
    throw FormatError(path.string(), 12, "a chunk that it holds");
  std::string text(bytes, '\0');
  file.read(text.data(), std::streamsize(bytes));
  json value = json::parse(text, nullptr, false);
  if (!file || value.is_discarded()) throw FormatError(path.string(), 20, "valid JSON");
  return value;
}

/// Reads no Gaussian.
Holds held_by(const std::filesystem::path& path) {
  const json gltf = head_of(path);
  const auto list = [&](const json& of, const char* key) {
    const auto found = of.is_object() ? of.find(key) : of.end();
    return found != of.end() && found->is_array() ? *found : json::array();
  };
  const json accessors = list(gltf, "accessors"), nodes = list(gltf, "nodes");
  Holds holds;
  std::size_t number = 0;
  for (const json& mesh : list(gltf, "meshes")) {
    const auto uses = std::count_if(nodes.begin(), nodes.end(), [&](const json& node) {
      return node.is_object() && node.value("mesh", -1) == int(number);
    });
    ++number;
    for (const json& primitive : list(mesh, "primitives")) {
      const auto attributes = primitive.find("attributes");
      if (attributes == primitive.end() || !attributes->is_object() || !primitive.contains("extensions"))
        continue;
      const std::string extensions = primitive["extensions"].dump();
      if (extensions.find("gaussian") == extensions.npos) continue;
      const std::size_t position = attributes->value("POSITION", accessors.size());
      if (position < accessors.size())
        holds.count += std::size_t(uses) * accessors[position].value("count", std::size_t(0));
      if (extensions.find("spz") != extensions.npos) holds.sh_degree = max_sh_degree;
      for (const auto& [key, value] : attributes->items())
        for (int degree = 1; degree <= max_sh_degree; ++degree)
          if (key.find("SH_DEGREE_" + std::to_string(degree)) != key.npos)
            holds.sh_degree = std::max(holds.sh_degree, degree);
    }
  }
  if (holds.count == 0) throw FormatError(path.string(), 0, "a glTF with Gaussians (KHR_gaussian_splatting)");
  return holds;
}

/// From axes of a scene in memory, whose x is left and y down of glTF's, to those of tiles, whose z points
/// up.
Affine tile_from_content() {
  Affine by;
  by.linear[0] = {-1, 0, 0}, by.linear[1] = {0, 0, -1}, by.linear[2] = {0, -1, 0};
  return by;
}

class Tiles {
 public:
  explicit Tiles(const std::filesystem::path& path) : path_(path), pages_(path) {}

  PagedScene open() && {
    add_tileset(path_, {}, 0);
    return std::move(pages_).finish("3D Tiles");
  }

 private:
  static constexpr std::uint32_t none = Page::none;

  /// Adds the pages of a tileset, and returns its root; `none` where it has no Gaussians.
  std::uint32_t add_tileset(const std::filesystem::path& file, const Affine& world_from_tileset, int level) {
    if (++tilesets_ > most_tilesets) pages_.fail("at most " + std::to_string(most_tilesets) + " tilesets");
    const json value = FilePages::parse(file);
    if (!value.is_object() || !value.contains("root") || !value["root"].is_object())
      throw FormatError(file.string(), 0, "a tileset of 3D Tiles, with a root");
    return add_tile(file, value["root"], world_from_tileset, false, level);
  }

  std::uint32_t add_tile(const std::filesystem::path& file, const json& tile, const Affine& above, bool adds,
                         int level) {
    if (level > most_levels) pages_.fail("at most " + std::to_string(most_levels) + " tiles in each other");
    const auto expect = [&](bool holds, const std::string& expected) {
      if (!holds) throw FormatError(file.string(), 0, expected);
    };
    expect(tile.is_object(), "tiles that are objects");
    const json extensions = tile.value("extensions", json::object());
    expect(!tile.contains("implicitTiling") && !extensions.contains("3DTILES_implicit_tiling"),
           "explicit tiling, found implicit tiling; write the tiles out one by one");
    const Affine world = above * transform_of(tile, expect);
    if (tile.contains("refine")) {
      expect(tile["refine"] == "ADD" || tile["refine"] == "REPLACE", "a refine of ADD or REPLACE");
      adds = tile["refine"] == "ADD";
    }
    expect(tile.contains("geometricError") && tile["geometricError"].is_number(),
           "tiles with a geometricError");
    const double error =
        tile["geometricError"].get<double>() * std::cbrt(std::abs(glm::determinant(world.linear)));

    std::vector<std::uint32_t> below;
    std::vector<FilePart> own;
    int sh_degree = 0;
    for (const json& content : contents_of(tile)) {
      const auto name =
          content.is_object() ? content.value("uri", content.value("url", std::string())) : std::string();
      const std::filesystem::path at = pages_.beside(file, name);
      if (at.extension() == ".json") {
        keep(below, add_tileset(at, world, level + 1));
        continue;
      }
      const Holds holds = held_by(at);
      own.push_back({at.string(), FilePart::all, holds.count, world * tile_from_content()});
      sh_degree = std::max(sh_degree, holds.sh_degree);
    }
    if (const auto children = tile.find("children"); children != tile.end()) {
      expect(children->is_array(), "an array of children");
      for (const json& child : *children) keep(below, add_tile(file, child, world, adds, level + 1));
    }
    if (own.empty() && below.empty()) return none;
    if (own.empty() && below.size() == 1) return below[0];
    const Bounds bounds = own.empty() ? pages_.bounds(below[0]) : bounds_of(tile, world, expect);
    if (own.empty()) {  // what is below stands for it, so that there is never a hole
      for (const std::uint32_t page : below) {
        own.insert(own.end(), pages_.parts(page).begin(), pages_.parts(page).end());
        sh_degree = max_sh_degree;
      }
    } else if (adds && !below.empty()) {
      below.push_back(pages_.add(own, bounds, 0, sh_degree, {}));
    }
    return pages_.add(std::move(own), bounds, error, sh_degree, std::move(below));
  }

  static void keep(std::vector<std::uint32_t>& pages, std::uint32_t page) {
    if (page != none) pages.push_back(page);
  }

  static std::vector<json> contents_of(const json& tile) {
    std::vector<json> all;
    if (const auto one = tile.find("content"); one != tile.end()) all.push_back(*one);
    if (const auto several = tile.find("contents"); several != tile.end() && several->is_array())
      all.insert(all.end(), several->begin(), several->end());
    return all;
  }

  template <class Expect>
  static std::vector<double> numbers(const json& value, std::size_t count, const Expect& expect,
                                     const char* what) {
    expect(value.is_array() && value.size() == count &&
               std::all_of(value.begin(), value.end(), [](const json& each) { return each.is_number(); }),
           std::to_string(count) + " numbers in " + what);
    return value.get<std::vector<double>>();
  }

  template <class Expect>
  static Affine transform_of(const json& tile, const Expect& expect) {
    Affine by;
    if (!tile.contains("transform")) return by;
    const std::vector<double> m = numbers(tile["transform"], 16, expect, "transform");
    expect(m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1, "a transform whose last row is 0, 0, 0, 1");
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row)
        by.linear[column][row] = m[4 * std::size_t(column) + std::size_t(row)];
    by.translation = {m[12], m[13], m[14]};
    expect(by.unmet() == nullptr, std::string("a transform with ") + (by.unmet() ? by.unmet() : ""));
    return by;
  }

  template <class Expect>
  static Bounds bounds_of(const json& tile, const Affine& world, const Expect& expect) {
    const json volume = tile.value("boundingVolume", json::object());
    Bounds bounds;
    dvec3 centre, half[3]{};
    if (volume.contains("box")) {
      const std::vector<double> b = numbers(volume["box"], 12, expect, "box");
      centre = {b[0], b[1], b[2]};
      for (std::size_t k = 0; k < 3; ++k) half[k] = {b[3 + 3 * k], b[4 + 3 * k], b[5 + 3 * k]};
    } else {
      expect(volume.contains("sphere"), "tiles with a boundingVolume of box or sphere");
      const std::vector<double> s = numbers(volume["sphere"], 4, expect, "sphere");
      centre = {s[0], s[1], s[2]};
      for (int k = 0; k < 3; ++k) half[k][k] = s[3];
    }
    for (int corner = 0; corner < 8; ++corner)
      bounds.add(world(centre + (corner & 1 ? 1.0 : -1.0) * half[0] + (corner & 2 ? 1.0 : -1.0) * half[1] +
                       (corner & 4 ? 1.0 : -1.0) * half[2]));
    return bounds;
  }

  std::filesystem::path path_;
  FilePages pages_;
  int tilesets_ = 0;
};

}  // namespace

PagedScene open_tiles(const std::filesystem::path& path) {
  return with_kinds(path, [&] { return Tiles(path).open(); });
}

}  // namespace swiftgs::pages
