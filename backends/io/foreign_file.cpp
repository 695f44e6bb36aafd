// SPDX-License-Identifier: Apache-2.0
#include "foreign_file.hpp"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <vector>

#include "camera_parsing.hpp"
#include "gltf_document.hpp"
#include "ksplat_layout.hpp"
#include "listed.hpp"
#include "name_ending.hpp"
#include "sog_files.hpp"
#include "spz_content.hpp"
#include "transforms_json.hpp"

namespace swiftgs::io {
namespace {

constexpr std::size_t beginning_bytes = 1 << 16;

struct Beginning {
  std::string_view text, name;
};

constexpr Beginning beginnings[] = {
    {"PXR-USDC", "a USD scene"},
    {"#usda", "a USD scene"},
    {"version https://git-lfs", "a pointer of Git LFS, whose content is not there"},
    {"<!DOCTYPE", "a page of HTML"},
    {"<!doctype", "a page of HTML"},
    {"<html", "a page of HTML"},
    {"\x89PNG", "a PNG image"},
    {"\xff\xd8\xff", "a JPEG image"},
    {"7z\xbc\xaf\x27\x1c", "a 7z archive; unpack it and give the scene in it"},
    {"Rar!\x1a\x07", "a RAR archive; unpack it and give the scene in it"},
    {"\3757zXZ", "a file packed by xz; unpack it and give the scene in it"},
    {"BZh", "a file packed by bzip2; unpack it and give the scene in it"},
    {"\x28\xb5\x2f\xfd", "a file packed by zstd; unpack it and give the scene in it"},
    // Scenes are looked at here only inside of other files.
    {"ply\n", "a PLY"},
    {"ply\r\n", "a PLY"},
};

/// A name that begins with `._` is that of what macOS stores beside a file.
bool is_scene_name(const std::string& name) {
  if (name.substr(name.rfind('/') + 1).starts_with("._")) return false;
  for (const char* ending : {".ply", ".spz", ".splat", ".ksplat", ".sog", ".glb", ".gltf", "meta.json"})
    if (has_ending(name, ending)) return true;
  return false;
}

/// `archive`, the files of which have `names`.
std::string archive_of(const std::string& archive, const std::vector<std::string>& names) {
  const auto is_pickle = [](const std::string& name) { return has_ending(name, "/data.pkl"); };
  if (std::any_of(names.begin(), names.end(), is_pickle))
    return "a checkpoint of PyTorch; export a PLY with the program that trained it";
  std::vector<std::string> scenes;
  std::copy_if(names.begin(), names.end(), std::back_inserter(scenes), is_scene_name);
  if (names.empty()) return archive;
  if (scenes.empty()) return archive + " of other files: " + listed(names);
  return archive + " with " + listed(scenes) + " in it; unpack it and give " +
         (scenes.size() == 1 ? "that file" : "one of these files");
}

bool is_tar(std::string_view text) { return text.size() >= 512 && text.substr(257, 5) == "ustar"; }

/// The names of files whose headers are in `text`: each fills 512 bytes, and what it holds as many more as it
/// needs. Folders and extended headers have types of their own.
std::vector<std::string> names_in_tar(std::string_view text) {
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

bool is_gzip(std::string_view text) { return text.starts_with("\x1f\x8b"); }

/// Looks into one gzip file alone: a file can be made that holds itself.
std::string gzip_of(std::string_view text) {
  const std::string inside = gzip_beginning(text, beginning_bytes);
  if (is_tar(inside)) return archive_of("a gzip file of a tar archive", names_in_tar(inside));
  const std::string what = is_gzip(inside) ? "a gzip file" : what_it_is(inside);
  const bool unpack = what == "a gzip file" || what == "a PLY" || what == "a glTF" || what == "a .ksplat";
  const char* advice = unpack                     ? "; unpack it with gunzip"
                       : what == "something else" ? "; if it is a .splat, unpack it with gunzip"
                                                  : "";
  return "a gzip file of " + what + advice;
}

}  // namespace

bool is_surely_foreign(std::string_view text) {
  if (text.starts_with("PK\3\4") || is_tar(text)) return true;
  // The fourth byte of gzip has flags, of which there are five.
  if (text.size() >= 4 && text.starts_with("\x1f\x8b\x08") && std::uint8_t(text[3]) < 32) return true;
  return std::any_of(std::begin(beginnings), std::end(beginnings), [&](const Beginning& beginning) {
    return beginning.text.size() >= 4 && text.starts_with(beginning.text);
  });
}

std::string what_it_is(std::string_view text) {
  const std::string_view beginning = text.substr(0, beginning_bytes);
  const auto holds = [&](std::string_view word) { return beginning.find(word) != std::string_view::npos; };
  if (text.empty()) return "an empty file";
  if (text.starts_with("PK")) {
    if (holds(".usdc") || holds(".usda")) return "a USD archive";
    return archive_of("a ZIP archive", names_in_bundle(text));
  }
  if (is_gzip(text)) return gzip_of(text);
  if (is_tar(text)) return archive_of("a tar archive", names_in_tar(text));
  for (const Beginning& known : beginnings)
    if (text.starts_with(known.text)) return std::string(known.name);
  if (looks_like_gltf(text)) return "a glTF";
  if (looks_like_ksplat(text)) return "a .ksplat";
  if (text.starts_with("{") || text.starts_with("[")) {
    if (holds("\"img_name\"")) return "JSON of cameras (cameras.json)";
    if (is_camera_path(beginning)) return "JSON of cameras (camera_path.json)";
    return is_transforms_json(beginning) ? "JSON of cameras (transforms.json)" : "JSON";
  }
  return "something else";
}

}  // namespace swiftgs::io
