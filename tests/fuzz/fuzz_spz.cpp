// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <span>

#include "scene_format.hpp"
#include "watched_read.hpp"

/// Any bytes are a scene or a `FormatError`.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  const swiftgs::io::Source source{bytes, "fuzz"};
  const bool gzip = source.text().starts_with("\x1f\x8b");
  swiftgs::fuzz::read_watched(
      bytes, gzip ? swiftgs::test::spz_memory : swiftgs::test::spz_streams_memory,
      [&](const auto& options) { return swiftgs::io::spz_format.read(source, options); });
  return 0;
}
