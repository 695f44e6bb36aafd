// SPDX-License-Identifier: Apache-2.0
#include "gltf_document.hpp"

#include <algorithm>
#include <charconv>

#include "text.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

constexpr std::string_view arrays[] = {"accessors", "bufferViews", "buffers", "meshes", "nodes", "scenes"};
constexpr std::string_view scheme = "data:";

/// The closing quote of the string whose first character is at `first`; npos if there is none.
std::size_t end_of_string(std::string_view text, std::size_t first) {
  std::size_t quote = text.find('"', first);
  while (true) {
    const std::size_t escape = text.substr(0, quote).find('\\', first);
    if (escape == text.npos || escape + 2 > text.size()) return quote;
    first = escape + 2;
    if (escape + 1 == quote) quote = text.find('"', first);
  }
}

}  // namespace

GltfDocument::GltfDocument(const Source& source) : source_(source), whole_(source.text()) {
  if (whole_.starts_with("glTF")) split_binary();
  cut_data_uris();
  parse();
}

void GltfDocument::split_binary() {
  binary_ = true;
  ByteReader reader(source_);
  reader.take(4, "'glTF'");
  const auto version = reader.read<std::uint32_t>("a version");
  if (version != 2) source_.fail(4, "version 2 of binary glTF, found version " + std::to_string(version));
  const auto length = reader.read<std::uint32_t>("a length");
  if (length != whole_.size())
    source_.fail(8, "a length of " + std::to_string(whole_.size()) + " bytes, as the file has, found " +
                        std::to_string(length));
  for (int number = 0; reader.remaining() > 0; ++number) {
    const auto size = reader.read<std::uint32_t>("the size of a chunk");
    const std::uint64_t type_offset = reader.position();
    const auto type = reader.read<std::uint32_t>("the type of a chunk");
    const std::uint64_t begin = reader.position();
    reader.take(size, "a chunk");
    if (number == 0 && type != 0x4e4f534a) source_.fail(type_offset, "a first chunk of JSON");
    if (number == 0) whole_ = source_.text().substr(begin, size);
    if (number == 1 && type == 0x004e4942) chunk_ = source_.bytes.subspan(begin, size);
  }
  if (whole_.size() == source_.bytes.size()) reader.fail("a chunk of JSON");
}

void GltfDocument::cut_data_uris() {
  std::size_t copied = 0;
  for (std::size_t at = whole_.find('"'); at != whole_.npos; at = whole_.find('"', at + 1)) {
    const std::size_t first = at + 1, end = end_of_string(whole_, first);
    if (end == whole_.npos) break;
    at = end;
    const std::string_view content = whole_.substr(first, end - first);
    if (!content.starts_with(scheme) || content.find('\\') != content.npos) continue;
    // No data URI is a number alone, as one has a comma.
    const std::string stand_in = std::string(scheme) + std::to_string(cuts_.size());
    shortened_ += whole_.substr(copied, first - copied);
    cuts_.push_back({shortened_.size(),
                     stand_in.size(),
                     {content, std::uint64_t(content.data() - source_.text().data())}});
    shortened_ += stand_in;
    copied = end;
  }
  if (!cuts_.empty()) shortened_ += whole_.substr(copied);
}

std::uint64_t GltfDocument::offset_of(std::uint64_t position) const {
  const auto after = std::upper_bound(cuts_.begin(), cuts_.end(), position,
                                      [](std::uint64_t p, const Cut& cut) { return p < cut.position; });
  if (after == cuts_.begin()) return std::uint64_t(whole_.data() - source_.text().data()) + position;
  const Cut& cut = *std::prev(after);
  const std::uint64_t past = position - cut.position;
  return past < cut.length ? cut.uri.offset : cut.uri.offset + cut.uri.text.size() + (past - cut.length);
}

void GltfDocument::parse() {
  const std::string_view json_text = text();
  try {
    root_ = parse_json({std::as_bytes(std::span(json_text)), source_.name});
  } catch (const FormatError& error) {
    source_.fail(offset_of(error.byte_offset()), "valid JSON, with numbers that a double can hold");
  }
  const std::size_t start = json_start(json_text);
  if (!root_.is_object()) source_.fail(offset_of(start), "a glTF (a JSON object)");
  const JsonEntry entry = root();
  for (const std::string_view name : arrays) {
    const std::string key(name);
    if (!entry.has(key.c_str())) continue;
    const std::uint64_t at = offset_of_member(json_text, start, name);
    const json& array = entry.member(key.c_str());
    if (!array.is_array()) source_.fail(offset_of(at), "'" + key + "' to be an array");
    std::vector<std::uint64_t>& offsets = offsets_[key];
    if (array.empty()) continue;
    offsets = offsets_in(json_text, at);
    for (std::uint64_t& offset : offsets) offset = offset_of(offset);
  }
}

std::size_t GltfDocument::size(const char* array) const {
  const auto found = root_.find(array);
  return found == root_.end() ? 0 : found->size();
}

JsonEntry GltfDocument::item(const char* array, std::uint64_t index, const JsonEntry& user) const {
  if (index >= size(array))
    user.fail("an index below " + std::to_string(size(array)) + " into '" + array + "', found " +
              std::to_string(index));
  static const std::map<std::string_view, const char*> what = {
      {"accessors", "an accessor"}, {"bufferViews", "a buffer view"},
      {"buffers", "a buffer"},      {"meshes", "a mesh"},
      {"nodes", "a node"},          {"scenes", "a scene"}};
  return {source_, root_.find(array)->at(index), offsets_.find(array)->second[index],
          what.find(array)->second};
}

std::optional<GltfDocument::DataUri> GltfDocument::data_uri(const JsonEntry& entry) const {
  const json& value = entry.member("uri");
  if (!value.is_string()) entry.fail("'uri' to be a string");
  const auto& uri = value.get_ref<const std::string&>();
  if (!uri.starts_with(scheme)) return std::nullopt;
  std::size_t number = 0;
  const char *first = uri.data() + scheme.size(), *last = uri.data() + uri.size();
  const auto [stop, error] = std::from_chars(first, last, number);
  if (error == std::errc() && stop == last && number < cuts_.size()) return cuts_[number].uri;
  return DataUri{uri, entry.offset()};
}

std::string shown(const json& value) {
  constexpr std::size_t most = 60;
  std::string text = value.dump(-1, ' ', true);
  if (text.size() > most) text = text.substr(0, most - 3) + "...";
  return text;
}

}  // namespace swiftgs::io
