// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include <swiftgs/scene.hpp>

#include "loss_meter.hpp"
#include "sog_codebook.hpp"
#include "sog_palette.hpp"
#include "webp_write.hpp"

/// @file
/// The images of a SOG of version 2. Pixel k is that of Gaussian `order[k]`. All numbers are finite.

namespace swiftgs::io {

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
