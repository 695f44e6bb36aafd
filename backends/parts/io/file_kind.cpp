// SPDX-License-Identifier: Apache-2.0
#include "file_kind.hpp"

#include <nlohmann/json.hpp>

#include "formats/spz/spz_content.hpp"
#include "json_entry.hpp"
#include "text.hpp"

namespace swiftgs::io {
namespace {

/// What a file is, and its format if it is a scene.
struct Finding {
  FileKind kind;
  const SceneFormat* format = nullptr;
};

/// Of kinds from `cameras_json` on.
constexpr const char* json_names[] = {"JSON of cameras (cameras.json)", "JSON of cameras (transforms.json)",
                                      "JSON of cameras (camera_path.json)", "a list of scenes"};

/// A file that is no scene may hold numbers that begin as JSON does, so that only its keys tell.
FileKind kind_of_json(std::string_view text) {
  const std::string_view json = text.substr(json_start(text));
  const auto holds = [&](std::string_view key) { return text.find(key) != text.npos; };
  if (json.starts_with('['))
    return holds("\"img_name\"") ? FileKind::cameras_json
           : holds("\"file\"")   ? FileKind::scene_list
                                 : FileKind::other;
  if (!json.starts_with('{')) return FileKind::other;
  // Of a long file only the beginning may be at hand, and the frames may follow later.
  if (holds("\"frames\"") || holds("\"transform_matrix\"") || holds("\"camera_angle_x\"") ||
      holds("\"fl_x\""))
    return FileKind::transforms_json;
  return holds("\"camera_path\"") ? FileKind::camera_path : FileKind::other;
}

Finding find(std::string_view text, std::string_view name) {
  for (const SceneFormat* format : scene_formats)
    if (format->has_mark && format->has_mark(text)) return {FileKind::scene, format};
  if (is_surely_foreign(text)) return {FileKind::other};
  for (const SceneFormat* format : scene_formats)
    if (format->looks_so && format->looks_so(text, name)) return {FileKind::scene, format};
  if (const FileKind kind = kind_of_json(text); kind != FileKind::other) return {kind};
  for (const SceneFormat* format : scene_formats)
    if (format->goes_by_name && is_named_as(*format, name)) return {FileKind::scene, format};
  return {FileKind::other};
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

FileKind kind_of(std::string_view text, std::string_view name) { return find(text, name).kind; }

const SceneFormat* scene_format_of(std::string_view text, std::string_view name) {
  return find(text, name).format;
}

std::string what_it_is(std::string_view text, std::string_view name) {
  if (text.empty()) return "an empty file";
  const auto [kind, format] = find(text, name);
  if (format) return std::string(format->name);
  if (kind != FileKind::other) return json_names[int(kind) - int(FileKind::cameras_json)];
  if (is_gzip(text)) return gzip_of(text);
  if (const std::string foreign = foreign_file(text, name); foreign != something_else) return foreign;
  if (const std::string_view encoding = other_encoding(text); !encoding.empty())
    return std::string("a text in ").append(encoding).append("; save it in UTF-8");
  if (begins_with_comment(text)) return "a text that begins with a comment, which JSON has not";
  const std::string_view words = text.substr(json_start(text));
  return words.starts_with('{') || words.starts_with('[') ? other_json(text) : something_else;
}

}  // namespace swiftgs::io
