// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <span>

#include <swiftgs/error.hpp>

#include "camera_parsing.hpp"

/// Any bytes are cameras or a `FormatError`, and every camera can be rendered with.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  try {
    for (const swiftgs::Camera& camera : swiftgs::io::parse_cameras_json({bytes, "fuzz"}))
      swiftgs::validate(camera);
  } catch (const swiftgs::FormatError&) {
  }
  return 0;
}
