// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One SOG: a bundle, a folder, or a chunk of a streamed one, with its images, which hold bytes and no
/// colours.

#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <swiftgs/edit/origin.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/scene.hpp>

#include "image_parsing.hpp"
#include "scene_building.hpp"
#include "sog_files.hpp"
#include "tasks.hpp"

namespace swiftgs::io {

/// Pixels of four bytes, rows from top to bottom.
using RgbaPixels = std::unique_ptr<std::uint8_t[]>;

/// The size that an image's header states. Throws `FormatError` unless it is a lossless WebP or a PNG.
ImageSize sog_image_size(const Source& source);

/// All bytes as they were stored: alpha is a number too, and multiplied with nothing. `size` is what
/// `sog_image_size` said.
RgbaPixels decode_sog_image(const Source& source, ImageSize size);

/// The files of a SOG, opened and checked but not decoded.
///
/// A hostile file cannot ask for memory that its size does not warrant. A SOG has at most 32 Gaussians for
/// each byte that its files take; an image of all Gaussians has at most two pixels a Gaussian and 65536 more;
/// and a palette has at most 65536 entries.
struct SogContent {
  SogMeta meta;
  std::array<SogFile, sog_image_kinds> files{};
  std::array<ImageSize, sog_image_kinds> sizes{};
  int sh_degree = 0;
  std::uint32_t palette_size = 0;
  std::uint64_t stored = 0;  ///< bytes of its files that were not counted before
};

/// Opens `source`, which is a bundle or `meta.json`. It must outlive what this returns.
SogContent open_sog(const Source& source);

/// Files whose bytes were already counted as a reason to take memory. A file counts once, even if several
/// names lead to it.
using CountedFiles = std::set<FileIdentity>;

/// Opens a bundle, or a `meta.json` whose images `open` opens. Adds its files to `counted`.
SogContent open_sog(const SogFile& file, const SogFiles& open, CountedFiles& counted);

/// What a SOG's images hold.
struct SogPixels {
  std::array<RgbaPixels, sog_image_kinds> images{};
  std::vector<float> palette{};  ///< @shape{palette_size, sh_rest_count(sh_degree), 3}
};

/// Decodes the images, several at a time, and closes their files.
SogPixels decode_images(SogContent& sog, const ProgressMeter& progress);

/// Some Gaussians of a SOG, and where they go in a scene of the same or a higher degree.
struct SogRange {
  std::size_t first, count, to;
};

/// Means are relative to the origin of `scene`. Returns how many Gaussians have a label that the palette
/// lacks: their harmonics stay as they are.
std::uint64_t decode_gaussians(const SogContent& sog, const SogPixels& pixels, const SogRange& range,
                               const ProgressMeter& progress, Scene& scene);

/// Adds the corners of the box that all Gaussians lie in.
void add_box(const SogContent& sog, OriginChoice& choice);

/// What the SOGs that make up a scene say beside their Gaussians.
class SogFindings {
 public:
  /// `odd_labels` is what `decode_gaussians` returned.
  void add(const SogMeta& meta, std::uint64_t odd_labels);

  /// Leaves out Gaussians with a fault, and sets `file`'s notes and its scene's model.
  void finish(SceneFile& file) const;

 private:
  bool antialiased_ = false, plain_ = false;
  RenderingModel::Kernel kernel_ = RenderingModel::Kernel::ellipsoid;
  std::string unknown_model_;
  std::uint64_t odd_labels_ = 0;
};

/// Whether a file is JSON with two keys of a SOG. Keys of a glTF may be any, these among them.
bool has_sog_keys(std::string_view text, std::string_view name, std::string_view first,
                  std::string_view second);

/// Reads `lod-meta.json`, whose chunks and their images `open` opens by names relative to it.
SceneFile read_streamed_sog(const Source& source, const SogFiles& open, const SceneReadOptions& options);

}  // namespace swiftgs::io
