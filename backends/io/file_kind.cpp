// SPDX-License-Identifier: Apache-2.0
#include "file_kind.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "archive.hpp"
#include "foreign_file.hpp"
#include "gltf_document.hpp"
#include "json_entry.hpp"
#include "ksplat_layout.hpp"
#include "name_ending.hpp"
#include "spz_content.hpp"
#include "text_beginning.hpp"

namespace swiftgs::io {
namespace {

/// In the order of `FileKind`.
constexpr const char* names[] = {"a PLY",
                                 "an SPZ",
                                 "a glTF",
                                 "a .ksplat",
                                 "a SOG",
                                 "a streamed SOG",
                                 "a .splat",
                                 "JSON of cameras (cameras.json)",
                                 "JSON of cameras (transforms.json)",
                                 "JSON of cameras (camera_path.json)",
                                 "a list of scenes"};

/// Whether the first line is `ply`. Exporters pad it, and end it in any way.
bool is_ply(std::string_view text) {
  text.remove_prefix(mark_bytes(text));
  if (!text.starts_with("ply")) return false;
  const std::size_t end = text.find_first_not_of(" \t", 3);
  return end != text.npos && (text[end] == '\n' || text[end] == '\r');
}

/// Whether an archive is a SOG. The list of its files is at its end. A streamed SOG is read by its folder
/// alone.
bool holds_sog(std::string_view archive) {
  const std::size_t end = archive.size() - std::min(archive.size(), beginning_bytes);
  return archive.rfind("meta.json") != archive.npos &&
         archive.substr(end).find("lod-meta.json") == archive.npos;
}

/// A file may hold numbers that begin as JSON does, so that only its keys tell.
FileKind kind_of_json(std::string_view text, std::string_view name) {
  const char first = text[json_start(text)];
  const auto holds = [&](std::string_view key) { return text.find(key) != text.npos; };
  if (first == '[')
    return holds("\"img_name\"") ? FileKind::cameras_json
           : holds("\"file\"")   ? FileKind::scene_list
                                 : FileKind::other;
  if (first != '{') return FileKind::other;
  if (looks_like_gltf(text) || has_ending(name, ".gltf")) return FileKind::gltf;
  if (holds("\"means\"") && holds("\"quats\"")) return FileKind::sog;
  if (holds("\"lodLevels\"") && holds("\"filenames\"")) return FileKind::streamed_sog;
  // Of a long file only the beginning may be at hand, and the frames may follow later.
  if (holds("\"frames\"") || holds("\"transform_matrix\"") || holds("\"camera_angle_x\"") ||
      holds("\"fl_x\""))
    return FileKind::transforms_json;
  return holds("\"camera_path\"") ? FileKind::camera_path : FileKind::other;
}

/// JSON that nobody reads.
std::string other_json(std::string_view text) {
  constexpr std::size_t most_bytes = 16 << 20;  // a tree of values takes many times the text
  if (text.size() > most_bytes) return "JSON";
  const nlohmann::json root = nlohmann::json::parse(text, nullptr, false);
  if (root.is_discarded()) return "a text that begins as JSON does and is none";
  return root.is_object() ? "a JSON object with " + listed_keys(root)
                          : "a JSON array; a list of scenes has objects with 'file'";
}

/// Looks into one gzip file alone: a file can be made that holds itself.
std::string gzip_of(std::string_view text) {
  const std::string inside = gzip_beginning(text, beginning_bytes);
  if (is_tar(inside)) return archive_of("a gzip file of a tar archive", names_in_tar(inside));
  const bool is_packed_twice = is_gzip(inside);
  const std::string what = is_packed_twice ? "a gzip file" : what_it_is(inside, "");
  const char* advice = is_packed_twice || kind_of(inside, "") != FileKind::other ? "; unpack it with gunzip"
                       : what == something_else ? "; if it is a .splat, unpack it with gunzip"
                                                : "";
  return "a gzip file of " + what + advice;
}

}  // namespace

FileKind kind_of(std::string_view text, std::string_view name) {
  if (is_ply(text)) return FileKind::ply;
  if (text.starts_with("NGSP") || is_gzip_of_spz(text)) return FileKind::spz;
  if (is_zip(text)) return holds_sog(text) ? FileKind::sog : FileKind::other;
  if (text.starts_with("glTF")) return FileKind::gltf;
  if (is_surely_foreign(text)) return FileKind::other;
  if (json_start(text) < text.size())
    if (const FileKind kind = kind_of_json(text, name); kind != FileKind::other) return kind;
  if (has_ending(name, ".ksplat") || looks_like_ksplat(text)) return FileKind::ksplat;
  return has_ending(name, ".splat") ? FileKind::splat : FileKind::other;
}

std::string what_it_is(std::string_view text, std::string_view name) {
  if (text.empty()) return "an empty file";
  if (const FileKind kind = kind_of(text, name); kind != FileKind::other) return names[int(kind)];
  if (is_gzip(text)) return gzip_of(text);
  if (const std::string foreign = foreign_file(text, name); foreign != something_else) return foreign;
  if (const std::string_view encoding = other_encoding(text); !encoding.empty())
    return std::string("a text in ").append(encoding).append("; save it in UTF-8");
  if (begins_with_comment(text)) return "a text that begins with a comment, which JSON has not";
  const std::string_view words = text.substr(json_start(text));
  return words.starts_with('{') || words.starts_with('[') ? other_json(text) : something_else;
}

}  // namespace swiftgs::io
