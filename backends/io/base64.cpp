// SPDX-License-Identifier: Apache-2.0
#include "base64.hpp"

#include <array>
#include <atomic>
#include <cstdint>

#include "parallel.hpp"

namespace swiftgs::io {
namespace {

constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::uint8_t invalid = 64;

constexpr std::array<std::uint8_t, 256> digit_values = [] {
  std::array<std::uint8_t, 256> table{};
  table.fill(invalid);
  for (std::size_t i = 0; i < alphabet.size(); ++i) table[std::uint8_t(alphabet[i])] = std::uint8_t(i);
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
  return (seen & invalid) == 0;
}

}  // namespace

std::size_t base64_size(std::string_view text) {
  const std::size_t length = without_padding(text).size();
  return length % 4 == 1 ? 0 : length / 4 * 3 + (length % 4) * 3 / 4;
}

std::size_t decode_base64(std::string_view text, std::byte* to, const ProgressMeter& progress) {
  text = without_padding(text);
  std::atomic<std::size_t> bad = text.npos;
  for_parts((text.size() + 3) / 4, progress, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (!decode_group(text.substr(4 * i, 4), to + 3 * i)) return bad.store(4 * i);
  });
  const std::size_t group = bad;
  return group == text.npos ? group : text.find_first_not_of(alphabet, group);
}

}  // namespace swiftgs::io
