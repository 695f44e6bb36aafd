// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <vector>

#include <swiftgs/edit/origin.hpp>
#include <swiftgs/scene.hpp>

#include "progress_meter.hpp"
#include "scene_building.hpp"
#include "sog_files.hpp"
#include "sog_image.hpp"
#include "sog_meta.hpp"

/// @file
/// One SOG: a bundle, a folder, or a chunk of a streamed one.

namespace swiftgs::io {

/// Its files, opened and checked but not decoded.
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

}  // namespace swiftgs::io
