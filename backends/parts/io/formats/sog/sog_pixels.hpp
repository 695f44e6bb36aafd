// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The images of a SOG of version 2, with codebooks and palettes. Pixel k is that of Gaussian `order[k]`. All
/// numbers are finite.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <swiftgs/scene.hpp>

#include "nearest_points.hpp"
#include "scene_encoding.hpp"
#include "tasks.hpp"

namespace swiftgs::io {

/// A number and how often it occurs.
struct Occurrence {
  float value = 0;
  float times = 1;
};

/// What each byte stands for: 256 ascending numbers.
class Codebook {
 public:
  /// At most `most` values, 1 to 256, with nearly the least sum of squared errors of `numbers`. They are
  /// exact if `numbers` has no more different ones. Numbers far from most get an
  /// eighth of the values at most, unless the others need fewer. The last is repeated to fill the table.
  static Codebook of(std::vector<Occurrence> numbers, std::size_t most = 256);

  /// The byte for the nearest number.
  std::uint8_t byte_of(float value) const;

  /// Puts a number smaller than all others at the front. Drops the last, which must be a repeated one.
  void prepend(float value);

  const std::array<float, 256>& values() const { return values_; }

 private:
  void set(const std::vector<double>& ascending);

  std::array<float, 256> values_{};
  std::array<float, 255> bounds_{};  ///< between a number and the next
};

/// Points that stand for others.
struct Palette {
  std::size_t width = 0;
  std::vector<float> colours{};         ///< `width` floats each
  std::vector<std::uint32_t> labels{};  ///< of each point its colour's number

  std::size_t size() const { return width == 0 ? 0 : colours.size() / width; }
};

/// At most `most` colours for `points`, with a small sum of squared distances: k-means. The same points give
/// the same palette. Takes time linear in `points.count`.
Palette make_palette(const Points& points, std::size_t most, const ProgressMeter& progress);

/// Points in groups, each of a few points near each other: group g has `order[begins[g]]` to
/// `order[begins[g + 1] - 1]`.
struct Grouping {
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> begins;

  std::size_t size() const { return begins.size() - 1; }
};

/// Splits all points into two groups, then always the group with the largest sum of squared distances to its
/// mean, until there are `most` groups or all points of a group are equal. Groups of one half come before
/// those of the other, so near groups often have near numbers.
Grouping split_points(const Points& points, std::size_t most, const ProgressMeter& progress);

/// Four bytes a pixel, red first, rows from top to bottom.
struct RgbaImage {
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> bytes{};
};

inline constexpr std::size_t most_webp_pixels_a_side = 16383;

/// Encodes lossless WebP and keeps the colours of transparent pixels. The same image gives the same file.
/// After `stopping` it returns early, with part of the file.
std::string encode_webp(const RgbaImage& image, const Stopping& stopping);

using Order = std::span<const std::uint32_t>;

/// Signed logarithms of the means in 16 bits, between the least and the largest.
class MeanEncoder {
 public:
  explicit MeanEncoder(const Scene& scene);

  /// The low bytes, or with `shift` 8 the high ones.
  RgbaImage image(const Scene& scene, Order order, int shift) const;

  /// What a reader makes of a mean.
  vec3 stored(const vec3& mean) const;

  const dvec3& least() const { return least_; }
  const dvec3& most() const { return most_; }

 private:
  long number(float coordinate, int axis) const;

  dvec3 least_, most_;
};

Codebook scale_codebook(const Scene& scene);
Codebook colour_codebook(const Scene& scene);
/// For the numbers of a palette's colours, each as often as Gaussians have it.
Codebook palette_codebook(const Palette& palette);

/// Gives `losses` the means, scales, opacities and colours that a reader will find in the images.
void measure_sog(const Scene& scene, const MeanEncoder& means, const Codebook& scales,
                 const Codebook& colours, LossMeter& losses);

RgbaImage scale_image(const Scene& scene, Order order, const Codebook& codebook);
RgbaImage rotation_image(const Scene& scene, Order order);
/// With opacities in the fourth byte.
RgbaImage colour_image(const Scene& scene, Order order, const Codebook& codebook);
RgbaImage label_image(const Palette& palette, Order order);
RgbaImage palette_image(const Palette& palette, const Codebook& codebook);

}  // namespace swiftgs::io
