// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

#include "file_kind.hpp"
#include "formats/sog/sog_files.hpp"
#include "scene_format.hpp"
#include "text.hpp"

namespace swiftgs::io {
namespace {

/// A name that begins with `._` is that of what macOS stores beside a file.
bool is_scene_name(const std::string& name) {
  if (name.substr(name.rfind('/') + 1).starts_with("._")) return false;
  return std::any_of(std::begin(scene_formats), std::end(scene_formats),
                     [&](const SceneFormat* format) { return is_named_as(*format, name); });
}

}  // namespace

std::vector<std::string> names_in_tar(std::string_view text) {
  // A header fills 512 bytes. The content of its file follows, padded to a multiple of 512 bytes. Folders and
  // extended headers have other types than files.
  std::vector<std::string> names;
  while (is_tar(text)) {
    const std::string_view name = text.substr(0, 100), size = text.substr(124, 11);
    const char type = text[156];
    if (type == '0' || type == '\0') names.emplace_back(name.substr(0, name.find('\0')));
    std::uint64_t bytes = 0;
    for (const char digit : size)
      if (digit >= '0' && digit <= '7') bytes = 8 * bytes + std::uint64_t(digit - '0');
    if (bytes > text.size()) break;
    text.remove_prefix(std::min<std::size_t>(text.size(), 512 + (bytes + 511) / 512 * 512));
  }
  return names;
}

std::string archive_of(const std::string& archive, const std::vector<std::string>& names) {
  const auto is_pickle = [](const std::string& name) { return has_ending(name, "/data.pkl"); };
  if (std::any_of(names.begin(), names.end(), is_pickle))
    return "a checkpoint of PyTorch; export a PLY with the program that trained it";
  const auto is_array = [](const std::string& name) { return has_ending(name, ".npy"); };
  if (!names.empty() && std::all_of(names.begin(), names.end(), is_array))
    return "arrays of NumPy (.npz); write a PLY of them";
  const auto is_streamed = [](const std::string& name) { return has_ending(name, "lod-meta.json"); };
  if (const auto found = std::find_if(names.begin(), names.end(), is_streamed); found != names.end())
    return archive + " of a streamed SOG; unpack it and give " + listed({*found});
  std::vector<std::string> scenes;
  std::copy_if(names.begin(), names.end(), std::back_inserter(scenes), is_scene_name);
  if (names.empty()) return archive;
  if (scenes.empty()) return archive + " of other files: " + listed(names);
  return archive + " with " + listed(scenes) + " in it; unpack it and give " +
         (scenes.size() == 1 ? "that file" : "one of these files");
}

namespace {

using namespace std::literals;

struct Known {
  std::string_view by, name;
};

/// What files begin with.
constexpr Known beginnings[] = {
    {"SGPAGES\n", "a page file; draw it by 'swiftgs render', 'swiftgs view' or PagePool"},
    {"PXR-USDC", "a USD scene"},
    {"#usda", "a USD scene"},
    {"RAD0", "a .rad of Spark; give the scene that it was made of"},
    {"RADC", "a part of a .rad of Spark; give the scene that it was made of"},
    {"version https://git-lfs", "a pointer of Git LFS, whose content is not there"},
    {"<!DOCTYPE", "a page of HTML"},
    {"<!doctype", "a page of HTML"},
    {"<html", "a page of HTML"},
    {"\x89PNG", "a PNG image"},
    {"\xff\xd8\xff", "a JPEG image"},
    {"GIF8", "a GIF image"},
    {"v/1\1", "an EXR image"},
    {"II*\0"sv, "a TIFF image"},
    {"MM\0*"sv, "a TIFF image"},
    {"\xabKTX ", "a KTX texture"},
    {"7z\xbc\xaf\x27\x1c", "a 7z archive; unpack it and give the scene in it"},
    {"Rar!\x1a\x07", "a RAR archive; unpack it and give the scene in it"},
    {"\3757zXZ", "a file packed by xz; unpack it and give the scene in it"},
    {"BZh", "a file packed by bzip2; unpack it and give the scene in it"},
    {"\x28\xb5\x2f\xfd", "a file packed by zstd; unpack it and give the scene in it"},
    {"\0\5\x16\7"sv, "what macOS stores beside a file; give the file whose name lacks the ._"},
    {"LASF", "a LAS point cloud, which holds no Gaussians"},
    {"ASTM-E57", "an E57 point cloud, which holds no Gaussians"},
    {"Kaydara FBX", "an FBX mesh, which holds no Gaussians"},
    {"; FBX", "an FBX mesh, which holds no Gaussians"},
    {"DRACO", "a mesh packed by Draco, which holds no Gaussians"},
    {"BLENDER", "a file of Blender; export a PLY from it"},
    {"\x93NUMPY", "an array of NumPy; write a PLY of it"},
    {"\x89HDF", "a file of HDF5; write a PLY of it"},
    {"SQLite format 3", "a database; of COLMAP, give the folder of a model that it wrote, such as sparse/0"},
    {"# Bundle file", "a model of Bundler; convert it with 'colmap model_converter'"},
    {"NVM_V3", "a model of VisualSFM; convert it with 'colmap model_converter'"},
};

constexpr std::string_view lcc = "an LCC scene of XGRIDS; export a PLY with the program that made it";
constexpr std::string_view checkpoint =
    "a checkpoint of PyTorch; export a PLY with the program that trained it";

/// How the names end of files that begin in many ways.
constexpr Known endings[] = {
    {".lcc", lcc},
    {".lcc2", lcc},
    {".hier", "a hierarchy of INRIA's hierarchical 3D Gaussians; give the PLY files that it was made of"},
    {".pt", checkpoint},
    {".pth", checkpoint},
    {".ckpt", checkpoint},
    {".safetensors", "a file of weights; export a PLY with the program that trained them"},
    {".obj", "an OBJ mesh, which holds no Gaussians"},
    {".stl", "an STL mesh, which holds no Gaussians"}};

/// Names that end so are of files that are told by their content.
constexpr std::string_view other_endings[] = {".rad", ".usd", ".usda", ".usdc", ".usdz", ".npz",
                                              ".npy", ".las", ".laz",  ".e57",  ".fbx",  ".dae",
                                              ".zip", ".tar", ".gz",   ".tgz",  ".7z",   ".rar"};

/// The strings of the members "uri" and "url" in `text`: where a tileset has its tiles.
std::vector<std::string> links_in(std::string_view text) {
  std::vector<std::string> links;
  for (std::size_t at = 0; (at = text.find("\"ur", at)) != text.npos;) {
    const std::string_view key = text.substr(at, 5);
    at += 5;
    if (key != "\"uri\"" && key != "\"url\"") continue;
    const std::size_t colon = text.find_first_not_of(" \t\r\n", at);
    const std::size_t quote = colon == text.npos ? colon : text.find_first_not_of(" \t\r\n", colon + 1);
    if (quote == text.npos || text[colon] != ':' || text[quote] != '"') continue;
    const std::size_t end = text.find('"', quote + 1);
    if (end != text.npos) links.emplace_back(text.substr(quote + 1, end - quote - 1));
  }
  return links;
}

/// JSON that programs write beside or in place of a scene; empty for any other text.
std::string foreign_json(std::string_view text) {
  text = text.substr(json_start(text), beginning_bytes);
  const auto holds = [&](std::string_view key) { return text.find(key) != text.npos; };
  if (!text.starts_with('{')) return {};
  if (is_tileset(text)) {
    const std::vector<std::string> links = links_in(text);
    return "a 3D Tiles tileset; give " + (links.size() == 1 ? listed(links)
                                          : links.empty()   ? "one of its .glb files"
                                                            : "one of its files: " + listed(links));
  }
  if (holds("\"totalSplats\"") && holds("\"fileType\"")) return std::string(lcc);
  if (holds("\"means\"") && holds("\"quats\"") && holds("\"opacities\"") && !holds("\"files\""))
    return "the meta.json of gsplat's PngCompression; write a PLY with gsplat's export_splats";
  return {};
}

std::string xml_of(std::string_view text) {
  const auto holds = [&](std::string_view word) { return text.find(word) != text.npos; };
  if (holds("<COLLADA")) return "a COLLADA mesh, which holds no Gaussians";
  return holds("<chunk") ? "cameras of Metashape; export them as a COLMAP model" : "a file of XML";
}

bool is_of_colmap(std::string_view name) {
  name = name.substr(name.rfind('/') + 1);
  for (const std::string_view stem : {"cameras", "images", "points3D", "rigs", "frames"})
    if (name.starts_with(stem) && (name.substr(stem.size()) == ".txt" || name.substr(stem.size()) == ".bin"))
      return true;
  return false;
}

}  // namespace

bool is_tileset(std::string_view text) {
  text = text.substr(json_start(text), beginning_bytes);
  return text.starts_with('{') && text.find("\"geometricError\"") != text.npos &&
         text.find("\"root\"") != text.npos;
}

bool is_surely_foreign(std::string_view text) {
  if (is_zip(text) || is_tar(text)) return true;
  // The fourth byte of gzip has flags, of which there are five.
  if (text.size() >= 4 && text.starts_with("\x1f\x8b\x08") && std::uint8_t(text[3]) < 32) return true;
  if (!foreign_json(text).empty()) return true;
  text.remove_prefix(mark_bytes(text));
  return std::any_of(std::begin(beginnings), std::end(beginnings),
                     [&](const Known& known) { return known.by.size() >= 4 && text.starts_with(known.by); });
}

std::string foreign_file(std::string_view text, std::string_view name) {
  const std::string_view beginning = text.substr(mark_bytes(text), beginning_bytes);
  if (text.starts_with("PK")) {
    const auto holds = [&](std::string_view word) { return beginning.find(word) != beginning.npos; };
    if (holds(".usdc") || holds(".usda")) return "a USD archive";
    return archive_of("a ZIP archive", names_in_bundle(text));
  }
  if (is_tar(text)) return archive_of("a tar archive", names_in_tar(text));
  for (const Known& known : beginnings)
    if (beginning.starts_with(known.by)) return std::string(known.name);
  if (beginning.starts_with("RIFF") && beginning.substr(8).starts_with("WEBP")) return "a WebP image";
  if (beginning.size() > 8 && beginning.substr(4, 4) == "ftyp") return "a video or a HEIF image";
  if (beginning.starts_with("<?xml")) return xml_of(beginning);
  if (std::string json = foreign_json(text); !json.empty()) return json;
  if (is_of_colmap(name)) return "a file of a COLMAP model, which is read by its folder";
  for (const Known& known : endings)
    if (has_ending(name, known.by)) return std::string(known.name);
  return something_else;
}

bool is_foreign_name(std::string_view name) {
  return name == "tileset.json" ||
         std::any_of(std::begin(endings), std::end(endings),
                     [&](const Known& known) { return has_ending(name, known.by); }) ||
         std::any_of(std::begin(other_endings), std::end(other_endings),
                     [&](std::string_view ending) { return has_ending(name, ending); });
}

}  // namespace swiftgs::io
