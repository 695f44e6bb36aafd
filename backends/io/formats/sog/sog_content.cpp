// SPDX-License-Identifier: Apache-2.0
#include "sog_content.hpp"

#include <string>

#include "tasks.hpp"

namespace swiftgs::io {
namespace {

constexpr std::uint64_t max_sog_gaussians_per_byte = 32, max_extra_pixels = 1 << 16;
constexpr std::uint32_t palette_columns = 64;  // entries in a row of the palette's image

std::uint64_t pixels_of(ImageSize size) { return std::uint64_t(size.width) * std::uint64_t(size.height); }

std::string to_text(ImageSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height) + " pixels";
}

void check_palette(SogContent& sog) {
  const Source& source = sog.files[sog_sh_palette].source;
  const ImageSize size = sog.sizes[sog_sh_palette];
  for (int degree = 1; degree <= max_sh_degree; ++degree)
    if (std::uint32_t(size.width) == palette_columns * std::uint32_t(sh_rest_count(degree)))
      sog.sh_degree = degree;
  if (sog.sh_degree == 0 || (sog.meta.sh_degree && *sog.meta.sh_degree != sog.sh_degree))
    source.fail(0, "a palette of harmonics 192, 512 or 960 pixels wide, as their degree asks for, found " +
                       to_text(size));
  const std::uint64_t entries = palette_columns * std::uint64_t(size.height);
  sog.palette_size = sog.meta.palette_size.value_or(std::uint32_t(entries));
  if (entries > 1 << 16 || sog.palette_size > entries)
    source.fail(0, "a palette of " + std::to_string(sog.palette_size) + " entries and at most 65536, found " +
                       to_text(size));
}

void check_pixels(const SogContent& sog, int kind) {
  const std::uint64_t count = sog.meta.count, pixels = pixels_of(sog.sizes[kind]);
  if (pixels < count || pixels > 2 * count + max_extra_pixels)
    sog.files[kind].source.fail(0, "about as many pixels as there are Gaussians, " + std::to_string(count) +
                                       ", found " + to_text(sog.sizes[kind]));
}

bool is_bundle(const Source& source) { return source.text().starts_with("PK"); }

/// Opens the images that `meta` names. `stored` bytes of other files count as theirs when the number of
/// Gaussians is checked against their size.
SogContent open_parts(const Source& meta, std::uint64_t stored, const SogFiles& open, CountedFiles& counted) {
  SogContent sog;
  sog.meta = parse_sog_meta(meta);
  bool shared = false;
  for (int kind = 0; kind < sog_image_kinds; ++kind) {
    if (sog.meta.images[kind].empty()) continue;
    SogFile& file = sog.files[kind] = open(sog.meta.images[kind]);
    if (counted.insert(file.identity).second)
      stored += file.stored;
    else
      shared = shared || file.stored > 0;
  }
  if (sog.meta.count / max_sog_gaussians_per_byte > stored)
    meta.fail(0, "files that can hold " + std::to_string(sog.meta.count) + " Gaussians, found " +
                     std::to_string(stored) + " bytes" + (shared ? " beside those that hold others" : ""));
  sog.stored = stored;
  for (int kind = 0; kind < sog_image_kinds; ++kind) {
    if (sog.meta.images[kind].empty()) continue;
    sog.sizes[kind] = sog_image_size(sog.files[kind].source);
    if (kind == sog_sh_palette)
      check_palette(sog);
    else
      check_pixels(sog, kind);
  }
  return sog;
}

void build_palette(const SogContent& sog, SogPixels& pixels) {
  const std::size_t values = 3 * std::size_t(sh_rest_count(sog.sh_degree)) * sog.palette_size;
  pixels.palette.resize(values);
  // The entries of a row lie side by side, and so do the rows.
  const std::uint8_t* rgba = pixels.images[sog_sh_palette].get();
  for (std::size_t i = 0; i < values; i += 3, rgba += 4)
    for (int c = 0; c < 3; ++c) pixels.palette[i + c] = sog.meta.sh[rgba[c]];
  pixels.images[sog_sh_palette].reset();
}

}  // namespace

SogContent open_sog(const Source& source) {
  CountedFiles counted;
  const SogFile file{source, source.bytes.size()};
  return open_sog(file, is_bundle(source) ? SogFiles() : files_beside(source), counted);
}

SogContent open_sog(const SogFile& file, const SogFiles& open, CountedFiles& counted) {
  const std::uint64_t stored = counted.insert(file.identity).second ? file.stored : 0;
  if (!is_bundle(file.source)) return open_parts(file.source, stored, open, counted);
  const SogFiles entries = files_of_bundle(file.source);
  return open_parts(entries("meta.json").source, stored, entries, counted);
}

SogPixels decode_images(SogContent& sog, const ProgressMeter& progress) {
  SogPixels pixels;
  const auto decode = [&](std::size_t kind, const Stopping&) {
    if (sog.meta.images[kind].empty()) return;
    pixels.images[kind] = decode_sog_image(sog.files[kind].source, sog.sizes[kind]);
    sog.files[kind] = {};
    if (kind == sog_sh_palette) build_palette(sog, pixels);
  };
  constexpr std::uint32_t few = 1 << 14;  // Gaussians; below this a thread costs more than it saves
  sog.meta.count < few ? for_short_tasks(sog_image_kinds, progress, decode)
                       : for_tasks(sog_image_kinds, progress, decode);
  return pixels;
}

}  // namespace swiftgs::io
