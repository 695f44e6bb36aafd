// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <span>

#include <swiftgs/error.hpp>
#include <swiftgs/io/image.hpp>

/// Any bytes are an image or a `FormatError`, and an image has all its pixels.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  try {
    const swiftgs::Image image = swiftgs::read_image(bytes, "fuzz");
    if (image.pixels.size() != std::size_t(image.width) * image.height * image.channels) __builtin_trap();
  } catch (const swiftgs::FormatError&) {
  }
  return 0;
}
