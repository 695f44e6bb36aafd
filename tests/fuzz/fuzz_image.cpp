// SPDX-License-Identifier: Apache-2.0
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include <swiftgs/error.hpp>
#include <swiftgs/io/image.hpp>

namespace {

/// Larger images reach no other code, and the fuzzer would spend its time on clearing their memory.
constexpr std::int64_t max_pixels = 256 * 256;
constexpr std::size_t max_attribute = 1 << 16;

bool is_large(std::int64_t width, std::int64_t height) {
  return width > 0 && height > 0 && width > max_pixels / height;
}

/// `size` bytes at `at` as a number, 0 where the text ends before.
std::int64_t number(std::string_view text, std::size_t at, std::size_t size, bool little) {
  if (at > text.size() || text.size() - at < size) return 0;
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i)
    value = value << 8 | std::uint8_t(text[little ? at + size - 1 - i : at + i]);
  return std::int64_t(value);
}

/// Any start-of-frame segment may be the one that counts.
bool is_large_jpeg(std::string_view text) {
  for (std::size_t at = text.find('\xff'); at != text.npos; at = text.find('\xff', at + 1)) {
    const std::int64_t marker = number(text, at + 1, 1, false);
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (is_frame && is_large(number(text, at + 7, 2, false), number(text, at + 5, 2, false))) return true;
  }
  return false;
}

bool is_large_pfm(std::string_view text) {
  std::int64_t sides[2] = {};
  std::size_t at = 2;
  for (std::int64_t& side : sides) {
    while (at < text.size() && std::isspace(std::uint8_t(text[at]))) ++at;
    for (; at < text.size() && std::isdigit(std::uint8_t(text[at])) && side <= max_pixels; ++at)
      side = 10 * side + (text[at] - '0');
  }
  return is_large(sides[0], sides[1]);
}

/// Where the text that starts at `at` ends, its 0 included.
std::size_t after_name(std::string_view text, std::size_t at) {
  const std::size_t end = text.find('\0', at);
  return end == text.npos ? text.size() : end + 1;
}

/// Bytes that OpenEXR reads for a value of this type; for most types as many as the header claims.
std::size_t value_size(std::string_view text, std::string_view type, std::size_t at, std::size_t claimed) {
  if (type == "compression" || type == "lineOrder") return 1;
  if (type == "float" || type == "int") return 4;
  if (type == "v2f") return 8;
  if (type == "tiledesc") return 9;
  if (type == "box2i") return 16;
  if (type != "chlist") return claimed;
  const std::size_t begin = at;
  while (at < text.size() && text[at] != '\0') at = after_name(text, at) + 16;
  return at + 1 - begin;
}

/// Whether an attribute claims to be larger than the file. OpenEXR takes and clears that much before it
/// reads.
bool has_large_attribute(std::string_view text) {
  std::size_t at = 8;
  while (at < text.size() && text[at] != '\0') {
    const std::size_t type = after_name(text, at), end = after_name(text, type);
    const std::size_t claimed = std::size_t(number(text, end, 4, true));
    if (end >= text.size()) return false;
    const std::size_t size = value_size(text, text.substr(type, end - type - 1), end + 4, claimed);
    if (size > max_attribute) return true;
    at = end + 4 + size;
  }
  return false;
}

/// Any box may be the window that counts, and any tile description the one of its tiles.
bool is_large_exr(std::string_view text) {
  const auto int32 = [&](std::size_t at) {
    return std::int64_t(std::int32_t(std::uint32_t(number(text, at, 4, true))));
  };
  // The type, its 0, and the size of the value stand before the value.
  for (std::size_t at = text.find("box2i"); at != text.npos; at = text.find("box2i", at + 1))
    if (is_large(int32(at + 18) - int32(at + 10) + 1, int32(at + 22) - int32(at + 14) + 1)) return true;
  for (std::size_t at = text.find("tiledesc"); at != text.npos; at = text.find("tiledesc", at + 1))
    if (is_large(number(text, at + 13, 4, true), number(text, at + 17, 4, true))) return true;
  return false;
}

/// Whether the header claims more than `max_pixels`. What has no header that can be read is not large.
bool claims_large(std::string_view text) {
  if (text.starts_with("\x89PNG")) return is_large(number(text, 16, 4, false), number(text, 20, 4, false));
  if (text.starts_with("\xff\xd8")) return is_large_jpeg(text);
  if (text.starts_with("PF") || text.starts_with("Pf")) return is_large_pfm(text);
  return has_large_attribute(text) || is_large_exr(text);
}

}  // namespace

/// Any bytes are an image or a `FormatError`, and an image has all its pixels.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (claims_large({reinterpret_cast<const char*>(data), size})) return 0;
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  try {
    const swiftgs::Image image = swiftgs::read_image(bytes, "fuzz");
    if (image.pixels.size() != std::size_t(image.width) * image.height * image.channels) __builtin_trap();
  } catch (const swiftgs::FormatError&) {
  }
  return 0;
}
