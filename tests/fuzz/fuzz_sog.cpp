// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include <swiftgs/error.hpp>

#include "scene_building.hpp"
#include "scene_readers.hpp"
#include "sog_content.hpp"

namespace {

using namespace swiftgs;

/// Files one behind the other, two bytes of length before each: meta.json, then images that are called 1 to
/// 7.
std::vector<std::span<const std::byte>> split(std::span<const std::byte> bytes) {
  std::vector<std::span<const std::byte>> files;
  while (bytes.size() >= 2 && files.size() < 8) {
    const std::size_t length = io::load<std::uint16_t>(bytes.data());
    const std::size_t size = std::min(length, bytes.size() - 2);
    files.push_back(bytes.subspan(2, size));
    bytes = bytes.subspan(2 + size);
  }
  return files;
}

/// A SOG whose files need no checksum, so that changes reach the images.
void read_files(std::span<const std::byte> bytes) {
  const auto files = split(bytes);
  if (files.empty()) return;
  const io::Source meta{files[0], "meta.json"};
  io::SogContent sog = io::open_sog(meta, files[0].size(), [&](const std::string& name) {
    const std::size_t index = name.size() == 1 ? std::size_t(name[0] - '0') : 0;
    if (index < 1 || index >= files.size()) meta.fail(0, "an image");
    return io::SogFile{{files[index], name}, files[index].size()};
  });
  const Progress none;
  const io::ProgressMeter progress(none, "fuzz");
  const io::SogPixels pixels = io::decode_images(sog, progress);
  Scene scene;
  io::allocate(scene, sog.meta.count, sog.sh_degree);
  io::decode_gaussians(sog, pixels, {0, sog.meta.count, 0}, progress, scene);
  io::drop_nonfinite(scene);
  validate(scene);
}

}  // namespace

/// Any bytes are a scene or a `FormatError`, and what is a scene is a valid one. Bytes are a bundle, the
/// description of a streamed SOG whose chunks are not there, or files as above.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  const io::Source source{bytes, "fuzz", "/nonexistent"};
  try {
    if (source.text().starts_with("PK"))
      validate(io::read_sog(source, {}).scene);
    else if (source.text().starts_with("{"))
      io::read_streamed_sog(source, {});
    else
      read_files(bytes);
  } catch (const FormatError&) {
  } catch (const std::system_error&) {  // no chunk can be opened
  }
  return 0;
}
