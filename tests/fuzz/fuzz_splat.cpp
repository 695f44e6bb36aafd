// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <span>

#include <swiftgs/error.hpp>

#include "scene_readers.hpp"

/// Any bytes are a scene or a `FormatError`, and what is a scene is a valid one.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  try {
    swiftgs::validate(swiftgs::io::read_splat({bytes, "fuzz"}, {}).scene);
  } catch (const swiftgs::FormatError&) {
  }
  return 0;
}
