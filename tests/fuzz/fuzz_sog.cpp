// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/sog/sog_content.hpp"
#include "scene_building.hpp"
#include "scene_format.hpp"
#include "watched_read.hpp"

namespace {

using namespace swiftgs;

/// Files one behind the other, two bytes of length before each. The first is meta.json or lod-meta.json, the
/// others are called 1, 2, ...
class Files {
 public:
  explicit Files(std::span<const std::byte> bytes) {
    while (bytes.size() >= 2 && files_.size() < 32) {
      const std::size_t length = io::load<std::uint16_t>(bytes.data());
      const std::size_t size = std::min(length, bytes.size() - 2);
      files_.push_back(bytes.subspan(2, size));
      bytes = bytes.subspan(2 + size);
    }
  }

  bool empty() const { return files_.empty(); }
  io::Source first() const { return {files_[0], "fuzz"}; }

  io::SogFile operator()(const std::string& name) const {
    std::size_t number = 0;
    std::from_chars(name.data(), name.data() + name.size(), number);
    if (number < 1 || number >= files_.size()) first().fail(0, "a file that is there");
    return {{files_[number], name}, files_[number].size(), {1, number}};
  }

 private:
  std::vector<std::span<const std::byte>> files_{};
};

/// A SOG whose files need no checksum, so that changes reach the images.
SceneFile read_folder(const Files& files, const SceneReadOptions& options) {
  io::CountedFiles counted;
  io::SogContent sog = io::open_sog({files.first(), files.first().bytes.size()}, files, counted);
  const io::ProgressMeter progress(options.progress, "fuzz");
  const io::SogPixels pixels = io::decode_images(sog, progress.step(0, 0.5));
  SceneFile file;
  io::allocate(file.scene, sog.meta.count, sog.sh_degree);
  io::decode_gaussians(sog, pixels, {0, sog.meta.count, 0}, progress.step(0.5, 1), file.scene);
  io::leave_out_invalid(file.scene);
  return file;
}

}  // namespace

/// Any bytes are a scene or a `FormatError`. Bytes are a bundle, or files as above: a SOG, or a streamed one
/// if the first names levels.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  const io::Source source{bytes, "fuzz"};
  const Files files(bytes);
  const bool bundle = source.text().starts_with("PK");
  if (!bundle && files.empty()) return 0;
  const bool streamed = !bundle && files.first().text().find("\"lodLevels\"") != std::string_view::npos;
  fuzz::read_watched(bytes, test::sog_memory, [&](SceneReadOptions options) {
    if (bundle) return io::sog_format.read(source, options);
    if (!streamed) return read_folder(files, options);
    options.level = std::to_integer<int>(bytes.back()) % 2;
    return io::read_streamed_sog(files.first(), files, options);
  });
  return 0;
}
