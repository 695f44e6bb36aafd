// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>

#include "parallel.hpp"
#include "scene_building.hpp"
#include "sog_content.hpp"
#include "sog_logarithm.hpp"

namespace swiftgs::io {
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
