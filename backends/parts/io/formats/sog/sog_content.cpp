// SPDX-License-Identifier: Apache-2.0

#include "sog_content.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <string>

#include "scene_building.hpp"
#include "sog_files.hpp"
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

namespace {

/// Coordinates are 16-bit signed logarithms, one byte of them in each of two images.
class MeanDecoder {
 public:
  explicit MeanDecoder(const SogMeta& meta)
      : least_(meta.mean_min), step_((meta.mean_max - meta.mean_min) / 65535.0) {}

  dvec3 operator()(const std::uint8_t* low, const std::uint8_t* high) const {
    dvec3 mean;
    for (int axis = 0; axis < 3; ++axis)
      mean[axis] = signed_exponential(least_[axis] + step_[axis] * (low[axis] | high[axis] << 8));
    return mean;
  }

 private:
  dvec3 least_, step_;
};

/// The fourth byte names the largest of w, x, y, z; the others hold the rest in that order. The format
/// defines no other fourth byte.
class RotationDecoder {
 public:
  RotationDecoder() {
    for (int byte = 0; byte < 256; ++byte) component_[byte] = float((byte / 255.0 - 0.5) * std::sqrt(2.0));
  }

  Quaternion operator()(const std::uint8_t* pixel) const {
    const int largest = pixel[3] - first_index;
    if (largest < 0) return not_a_rotation;
    std::array<float, 4> wxyz;
    float squares = 0;
    for (int i = 0; i < 4; ++i) {
      if (i == largest) continue;
      wxyz[i] = component_[*pixel++];
      squares += wxyz[i] * wxyz[i];
    }
    wxyz[largest] = std::sqrt(std::max(0.0f, 1 - squares));
    return normalised(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  }

 private:
  static constexpr int first_index = 252;

  SogMeta::Table component_;
};

vec3 three(const std::array<SogMeta::Table, 3>& tables, const std::uint8_t* pixel) {
  return {tables[0][pixel[0]], tables[1][pixel[1]], tables[2][pixel[2]]};
}

}  // namespace

std::uint64_t decode_gaussians(const SogContent& sog, const SogPixels& pixels, const SogRange& range,
                               const ProgressMeter& progress, Scene& scene) {
  const std::size_t rest = 3 * std::size_t(sh_rest_count(sog.sh_degree));
  const std::size_t stride = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  const MeanDecoder mean(sog.meta);
  const RotationDecoder rotation;
  std::atomic<std::uint64_t> odd_labels = 0;
  for_parts(range.count, progress, [&](std::size_t begin, std::size_t end) {
    std::uint64_t odd = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const auto pixel = [&](SogImageKind kind) { return pixels.images[kind].get() + 4 * (range.first + i); };
      const std::size_t to = range.to + i;
      scene.means[to] = vec3(mean(pixel(sog_means_low), pixel(sog_means_high)) - scene.origin);
      scene.scales[to] = three(sog.meta.scales, pixel(sog_scales));
      scene.rotations[to] = rotation(pixel(sog_rotations));
      scene.sh0[to] = three(sog.meta.colours, pixel(sog_colours));
      scene.opacities[to] = sog.meta.opacities[pixel(sog_colours)[3]];
      if (rest != 0) {
        const std::size_t label = pixel(sog_sh_labels)[0] | std::size_t(pixel(sog_sh_labels)[1]) << 8;
        if (label < sog.palette_size)
          std::memcpy(scene.sh_rest.data() + to * stride, pixels.palette.data() + label * rest,
                      rest * sizeof(float));
        else
          ++odd;
      }
    }
    odd_labels += odd;
  });
  return odd_labels;
}

void add_box(const SogContent& sog, OriginChoice& choice) {
  float largest = 0;
  for (const SogMeta::Table& scales : sog.meta.scales)
    largest = std::max(largest, *std::max_element(scales.begin(), scales.end()));
  for (const dvec3& corner : {sog.meta.mean_min, sog.meta.mean_max}) {
    dvec3 position;
    for (int axis = 0; axis < 3; ++axis) position[axis] = signed_exponential(corner[axis]);
    choice.add(position, largest);
  }
}

}  // namespace swiftgs::io
