// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <span>

#include "scene_format.hpp"
#include "watched_read.hpp"

/// Any bytes are a scene or a `FormatError`. No other file is opened.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  swiftgs::fuzz::read_watched(bytes, swiftgs::test::SWIFTGS_FUZZED_MEMORY, [&](const auto& options) {
    return swiftgs::io::SWIFTGS_FUZZED_FORMAT.read({bytes, "fuzz"}, options);
  });
  return 0;
}
