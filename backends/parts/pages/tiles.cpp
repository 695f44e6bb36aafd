// SPDX-License-Identifier: Apache-2.0

// 3D Tiles 1.1 with explicit tiling, whose content is glTF with Gaussians.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <glm/matrix.hpp>

#include <swiftgs/error.hpp>
#include <swiftgs/scene.hpp>

#include "file_pages.hpp"
#include "formats/gltf/gltf_primitive.hpp"
#include "json_entry.hpp"
#include "mapped_file.hpp"
#include "page_file.hpp"

namespace swiftgs::pages {
namespace {

using nlohmann::json;

/// Most tilesets of a model: a few small files may name the same others many times.
constexpr int most_tilesets = 1 << 16;

/// Number and harmonic degree of the Gaussians of a glTF.
struct Holds {
  std::size_t count = 0;
  int sh_degree = 0;
};

/// The JSON of a glTF: all of a text file, the first chunk of a binary one.
json head_of(const std::filesystem::path& path) {
  constexpr std::size_t begin = 20;  // of the first chunk
  const io::MappedFile file(path);
  const io::Source source{file.bytes(), path.string()};
  for (const char* const other : {"b3dm", "i3dm", "pnts", "cmpt"})
    if (source.text().starts_with(other)) source.fail(0, std::string("a glTF, found content of ") + other);
  if (!source.text().starts_with("glTF")) return io::parse_json(source);
  if (source.bytes.size() < begin) source.fail(0, "a header of 20 bytes");
  const auto bytes = io::load<std::uint32_t>(source.bytes.data() + 12);
  if (bytes > source.bytes.size() - begin) source.fail(12, "a chunk that it holds");
  return io::parse_json({source.bytes.subspan(begin, bytes), source.name});
}

/// The member of `of` if it is an array, or an object; else an empty one.
const json& array_in(const json& of, const char* key) {
  static const json none = json::array();
  const auto found = of.find(key);  // the end of what is no object
  return found != of.end() && found->is_array() ? *found : none;
}
const json& object_in(const json& of, const char* key) {
  static const json none = json::object();
  const auto found = of.find(key);
  return found != of.end() && found->is_object() ? *found : none;
}

/// Adds the Gaussians of a primitive of a mesh that `uses` nodes show.
void add_primitive(const json& primitive, const json& accessors, std::size_t uses, Holds& holds) {
  const json& extensions = object_in(primitive, "extensions");
  const json& own = object_in(extensions, "KHR_gaussian_splatting");
  const json& nested = object_in(own, "extensions");
  const bool packed =
      std::any_of(std::begin(io::gltf_spz_extensions), std::end(io::gltf_spz_extensions),
                  [&](const char* name) { return nested.contains(name) || extensions.contains(name); });
  if (!packed && !extensions.contains("KHR_gaussian_splatting")) return;
  const json& attributes = object_in(primitive, "attributes");
  const std::size_t position = attributes.value("POSITION", accessors.size());
  // A count of 2^32 is refused like any above it, and its product does not wrap.
  if (position < accessors.size())
    holds.count += uses * std::min<std::size_t>(accessors[position].value("count", std::size_t(0)),
                                                std::size_t(1) << 32);
  if (packed) holds.sh_degree = max_sh_degree;
  for (const auto& [key, value] : attributes.items())
    for (int degree = 1; degree <= max_sh_degree; ++degree)
      if (key.find("SH_DEGREE_" + std::to_string(degree)) != key.npos)
        holds.sh_degree = std::max(holds.sh_degree, degree);
}

/// Reads no Gaussian.
Holds held_by(const std::filesystem::path& path) {
  const json gltf = head_of(path);
  const json &accessors = array_in(gltf, "accessors"), &meshes = array_in(gltf, "meshes");
  std::vector<std::size_t> uses(meshes.size());
  for (const json& node : array_in(gltf, "nodes"))
    if (const auto mesh = node.find("mesh"); mesh != node.end())
      if (const auto number = mesh->get<std::size_t>(); number < uses.size()) ++uses[number];
  Holds holds;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    for (const json& primitive : array_in(meshes[i], "primitives")) {
      add_primitive(primitive, accessors, uses[i], holds);
      if (holds.count >> 32 != 0) throw FormatError(path.string(), 0, "fewer than 2^32 Gaussians");
    }
  if (holds.count == 0) throw FormatError(path.string(), 0, "a glTF with Gaussians (KHR_gaussian_splatting)");
  return holds;
}

/// Maps axes of a scene in memory to axes of tiles. Those of memory have glTF's x and y reversed; those of
/// tiles have z up.
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
    if (std::find(open_.begin(), open_.end(), file) != open_.end())
      throw FormatError(file.string(), 0, "a tileset that does not hold itself");
    const json value = json_of(file);
    if (!value.is_object() || !value.contains("root") || !value["root"].is_object())
      throw FormatError(file.string(), 0, "a tileset of 3D Tiles, with a root");
    open_.push_back(file);
    const std::uint32_t root =
        with_kinds(file, [&] { return add_tile(file, value["root"], world_from_tileset, false, level); });
    open_.pop_back();
    return root;
  }

  const Holds& holds_of(const std::filesystem::path& file) {
    const auto known = held_.find(file);
    if (known != held_.end()) return known->second;
    return held_.emplace(file, with_kinds(file, [&] { return held_by(file); })).first->second;
  }

  /// The file that content of the tileset `file` names.
  static std::filesystem::path beside(const std::filesystem::path& file, const std::string& uri) {
    const std::filesystem::path path = io::path_of_uri(uri);
    if (path.empty())
      throw FormatError(file.string(), 0,
                        "names of files in the same folder or below it, found '" + uri + "'");
    return file.parent_path() / path;
  }

  std::uint32_t add_tile(const std::filesystem::path& file, const json& tile, const Affine& above, bool adds,
                         int level) {
    if (level > most_levels) pages_.fail("at most " + std::to_string(most_levels) + " tiles in each other");
    const auto expect = [&](bool holds, const std::string& expected) {
      if (!holds) throw FormatError(file.string(), 0, expected);
    };
    expect(tile.is_object(), "tiles that are objects");
    expect(!tile.contains("implicitTiling") &&
               !object_in(tile, "extensions").contains("3DTILES_implicit_tiling"),
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
    for (const json* content : contents_of(tile)) {
      const auto name = content->value("uri", content->value("url", std::string()));
      const std::filesystem::path at = beside(file, name);
      if (at.extension() == ".json") {
        keep(below, add_tileset(at, world, level + 1));
        continue;
      }
      const Holds& holds = holds_of(at);
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

  static std::vector<const json*> contents_of(const json& tile) {
    std::vector<const json*> all;
    if (const auto one = tile.find("content"); one != tile.end()) all.push_back(&*one);
    for (const json& each : array_in(tile, "contents")) all.push_back(&each);
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
    const json& volume = object_in(tile, "boundingVolume");
    Bounds bounds;
    dvec3 centre, half[3]{};
    if (volume.contains("box")) {
      const std::vector<double> b = numbers(volume["box"], 12, expect, "box");
      centre = {b[0], b[1], b[2]};
      for (std::size_t k = 0; k < 3; ++k) half[k] = {b[3 + 3 * k], b[4 + 3 * k], b[5 + 3 * k]};
    } else {
      expect(volume.contains("sphere"), std::string("tiles with a boundingVolume of box or sphere") +
                                            (volume.contains("region") ? ", found a region" : ""));
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
  std::vector<std::filesystem::path> open_;  ///< tilesets that are being read
  std::map<std::filesystem::path, Holds> held_;
};

}  // namespace

PagedScene open_tiles(const std::filesystem::path& path) { return Tiles(path).open(); }

}  // namespace swiftgs::pages
