// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cstdint>

#include "gltf_primitive.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

constexpr std::string_view base64_digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::uint8_t no_digit = 64;

constexpr std::array<std::uint8_t, 256> digit_values = [] {
  std::array<std::uint8_t, 256> table{};
  table.fill(no_digit);
  for (std::size_t i = 0; i < base64_digits.size(); ++i)
    table[std::uint8_t(base64_digits[i])] = std::uint8_t(i);
  return table;
}();

std::string_view without_padding(std::string_view text) {
  for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);
  return text;
}

/// Up to four characters stand for one byte less. Returns whether all are of the alphabet.
bool decode_group(std::string_view group, std::byte* to) {
  std::uint32_t bits = 0;
  std::uint8_t seen = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint8_t value = i < group.size() ? digit_values[std::uint8_t(group[i])] : std::uint8_t(0);
    bits = bits << 6 | (value & 63u), seen |= value;
  }
  for (std::size_t i = 0; i + 1 < group.size(); ++i) to[i] = std::byte(bits >> (16 - 8 * i) & 255);
  return (seen & no_digit) == 0;
}

/// Bytes that `text` stands for, in the standard alphabet, with or without padding; 0 if no bytes have such a
/// length.
std::size_t base64_size(std::string_view text) {
  const std::size_t length = without_padding(text).size();
  return length % 4 == 1 ? 0 : length / 4 * 3 + (length % 4) * 3 / 4;
}

/// Decodes `text` to `base64_size(text)` bytes on all cores. Returns the position of a character that is not
/// of the alphabet, or npos.
std::size_t decode_base64(std::string_view text, std::byte* to, const ProgressMeter& progress) {
  text = without_padding(text);
  std::atomic<std::size_t> bad = text.npos;
  for_parts((text.size() + 3) / 4, progress, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (!decode_group(text.substr(4 * i, 4), to + 3 * i)) return bad.store(4 * i);
  });
  const std::size_t group = bad;
  return group == text.npos ? group : text.find_first_not_of(base64_digits, group);
}

}  // namespace

std::filesystem::path path_of_uri(std::string_view uri) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned char c = static_cast<unsigned char>(uri[i]);
    if (c == '%') {
      const std::string_view digits = uri.substr(i + 1, 2);
      const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), c, 16);
      if (error != std::errc() || digits.size() != 2 || stop != digits.data() + 2) return {};
      i += 2;
    }
    decoded += char(c);
  }
  // A colon would be of another scheme or of a drive, and some systems take a backslash for a slash.
  if (decoded.find_first_of(std::string_view(":\\\0", 3)) != decoded.npos) return {};
  const std::filesystem::path path(decoded);
  if (!path.has_filename() || path.is_absolute()) return {};
  for (const auto& part : path)
    if (part == "..") return {};
  return path.lexically_normal();
}

std::span<const std::byte> GltfBuffers::decode(const GltfDocument::DataUri& uri) {
  constexpr std::string_view marker = ";base64,";
  const std::size_t comma = uri.text.find(',');
  const std::size_t first = comma + 1;
  if (comma == uri.text.npos || !uri.text.substr(0, first).ends_with(marker))
    document_.source().fail(uri.offset, "a data URI in base64");
  const std::string_view text = uri.text.substr(first);
  const std::size_t size = base64_size(text);
  if (size == 0)
    document_.source().fail(uri.offset + first,
                            "whole bytes in base64, found " + std::to_string(text.size()) + " characters");
  decoded_.push_back(std::make_unique_for_overwrite<std::byte[]>(size));
  const auto whole = double(document_.source().bytes.size());
  const double begin = double(characters_) / whole;
  characters_ += text.size();
  const auto progress = progress_.step(std::min(begin, 1.0), std::min(double(characters_) / whole, 1.0));
  if (const std::size_t bad = decode_base64(text, decoded_.back().get(), progress); bad != text.npos)
    document_.source().fail(uri.offset + first + bad, "a character of base64");
  return counted({decoded_.back().get(), size});
}

std::span<const std::byte> GltfBuffers::open(std::uint64_t index, const JsonEntry& entry) {
  if (!entry.has("uri")) {
    if (index == 0 && document_.chunk()) return counted(*document_.chunk());
    entry.fail("a buffer with 'uri'" + std::string(document_.binary() ? ", or a second chunk" : ""));
  }
  if (const auto uri = document_.data_uri(entry)) return decode(*uri);
  const std::string uri = shown(entry.member("uri"));
  const std::filesystem::path path = path_of_uri(entry.string("uri"));
  if (path.empty()) entry.fail("a 'uri' of a file in the folder of this one, found " + uri);
  const std::filesystem::path& folder = document_.source().folder;
  if (folder.empty()) entry.fail("a glTF with all buffers inside, as it is read from memory, found " + uri);
  std::unique_ptr<MappedFile>& file = files_[path];
  if (file) return file->bytes();
  file = std::make_unique<MappedFile>(folder / path);
  if (!opened_.insert(file->identity()).second) return file->bytes();
  size_beside_ += file->bytes().size();
  return counted(file->bytes());
}

std::span<const std::byte> GltfBuffers::buffer(std::uint64_t index, const JsonEntry& user) {
  if (const auto found = buffers_.find(index); found != buffers_.end()) return found->second;
  const JsonEntry entry = document_.item("buffers", index, user);
  const std::uint64_t length = whole_number(entry, "byteLength");
  const std::span<const std::byte> bytes = open(index, entry);
  if (length > bytes.size())
    entry.fail("a buffer of " + std::to_string(length) + " bytes ('byteLength'), found " +
               std::to_string(bytes.size()));
  return buffers_[index] = bytes.first(length);
}

GltfBuffers::View GltfBuffers::view(std::uint64_t index, const JsonEntry& user) {
  const JsonEntry entry = document_.item("bufferViews", index, user);
  const std::span<const std::byte> bytes = buffer(whole_number(entry, "buffer"), entry);
  const std::uint64_t offset = whole_number(entry, "byteOffset", 0);
  const std::uint64_t length = whole_number(entry, "byteLength");
  if (offset > bytes.size() || length > bytes.size() - offset)
    entry.fail("a buffer view inside its buffer of " + std::to_string(bytes.size()) + " bytes, found " +
               std::to_string(length) + " bytes from byte " + std::to_string(offset));
  return {bytes.subspan(offset, length), whole_number(entry, "byteStride", 0)};
}

namespace {

std::uint64_t component_size(const JsonEntry& entry, std::uint64_t type) {
  switch (type) {
    case GltfAccessor::i8:
    case GltfAccessor::u8:
      return 1;
    case GltfAccessor::i16:
    case GltfAccessor::u16:
      return 2;
    case GltfAccessor::f32:
      return 4;
    default:
      entry.fail("a 'componentType' of 5120 to 5123 or 5126, found " + std::to_string(type));
  }
}

}  // namespace

GltfAccessor find_accessor(const GltfDocument& document, GltfBuffers& buffers, std::uint64_t index,
                           const JsonEntry& user, const std::string& attribute, int components) {
  const JsonEntry entry = document.item("accessors", index, user);
  const std::string type = components == 1 ? "SCALAR" : "VEC" + std::to_string(components);
  if (entry.string("type") != type)
    entry.fail(attribute + " to be of type " + type + ", found " + shown(entry.member("type")));
  if (entry.has("sparse")) entry.fail(attribute + " without 'sparse', which is not supported");
  if (!entry.has("bufferView")) entry.fail(attribute + " with a 'bufferView'");

  GltfAccessor accessor{.offset = entry.offset()};
  const std::uint64_t component = whole_number(entry, "componentType");
  const std::uint64_t size = component_size(entry, component) * std::uint64_t(components);
  accessor.type = GltfAccessor::Type(component);
  if (entry.has("normalized")) {
    const nlohmann::json& normalised = entry.member("normalized");
    if (!normalised.is_boolean()) entry.fail("'normalized' to be true or false");
    accessor.normalised = normalised.get<bool>();
  }
  accessor.count = whole_number(entry, "count");
  if (accessor.count == 0) entry.fail(attribute + " of at least one Gaussian");

  const auto view = buffers.view(whole_number(entry, "bufferView"), entry);
  accessor.stride = view.stride == 0 ? size : view.stride;
  if (accessor.stride < size)
    entry.fail(attribute + " of " + std::to_string(size) +
               " bytes in a 'byteStride' of at least that, found " + std::to_string(view.stride));
  const std::uint64_t offset = whole_number(entry, "byteOffset", 0), room = view.bytes.size();
  if (offset > room || size > room - offset || accessor.count - 1 > (room - offset - size) / accessor.stride)
    entry.fail(attribute + " of " + std::to_string(accessor.count) + " Gaussians inside its buffer view of " +
               std::to_string(room) + " bytes");
  accessor.data = view.bytes.data() + offset;
  return accessor;
}

}  // namespace swiftgs::io
