// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include <swiftgs/error.hpp>

#include "camera_parsing.hpp"

/// The first byte chooses the encoding, the second how many bytes are the cameras file; the rest are the
/// images. Any such pair is cameras or a `FormatError`, and every camera can be rendered with.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::span bytes(reinterpret_cast<const std::byte*>(data + 2), size - 2);
  const std::size_t split = std::min<std::size_t>(data[1], bytes.size());
  const auto parse = data[0] & 1 ? swiftgs::io::parse_colmap_text : swiftgs::io::parse_colmap_binary;
  try {
    for (const swiftgs::Camera& camera :
         parse({bytes.first(split), "cameras"}, {bytes.subspan(split), "images"}))
      swiftgs::validate(camera);
  } catch (const swiftgs::FormatError&) {
  }
  return 0;
}
