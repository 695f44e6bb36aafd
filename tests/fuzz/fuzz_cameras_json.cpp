// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <span>

#include <swiftgs/error.hpp>

#include "camera_parsing.hpp"

namespace {

template <class Parse>
void expect_cameras(Parse parse) {
  try {
    for (const swiftgs::Camera& camera : parse().cameras) swiftgs::validate(camera);
  } catch (const swiftgs::FormatError&) {
  }
}

}  // namespace

/// Any bytes are cameras or a `FormatError`, and every camera can be rendered with. Any bytes may also lie
/// beside a transforms.json, as its dataparser_transforms.json.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  const swiftgs::io::Source source{bytes, "fuzz"};
  expect_cameras([&] { return swiftgs::io::parse_cameras_json(source); });
  expect_cameras([&] { return swiftgs::io::parse_transforms_json(source); });
  expect_cameras([&] { return swiftgs::io::parse_transforms_json(source, {}, &source); });
  expect_cameras([&] { return swiftgs::io::parse_camera_path(source); });
  return 0;
}
