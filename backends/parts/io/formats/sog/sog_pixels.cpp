// SPDX-License-Identifier: Apache-2.0
#include "sog_pixels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "scene_encoding.hpp"
#include "sog_files.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

using Pixel = std::array<std::uint8_t, 4>;

/// `pixel(i)` is that of Gaussian i. Sides are multiples of four, about equal.
template <class ToPixel>
RgbaImage image_of(Order order, const ToPixel& pixel) {
  const auto fours = [](double value) { return 4 * std::size_t(std::ceil(value / 4)); };
  RgbaImage image;
  image.width = fours(std::sqrt(double(order.size())));
  image.height = fours(std::ceil(double(order.size()) / double(image.width)));
  image.bytes.resize(4 * image.width * image.height);
  auto to = image.bytes.begin();
  for (const std::uint32_t i : order) {
    const Pixel bytes = pixel(i);
    to = std::copy(bytes.begin(), bytes.end(), to);
  }
  return image;
}

std::uint8_t byte_of_part(double part) { return std::uint8_t(std::lround(std::clamp(part, 0.0, 1.0) * 255)); }

/// The three components that are not the largest, in [-sqrt(1/2), sqrt(1/2)], and which is the largest.
Pixel rotation_pixel(const Quaternion& q) {
  std::array<double, 4> wxyz{q.w, q.x, q.y, q.z};
  double squares = 0;
  for (const double value : wxyz) squares += value * value;
  if (squares == 0) wxyz[0] = squares = 1;
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i)
    if (std::abs(wxyz[i]) > std::abs(wxyz[largest])) largest = i;
  const double factor = std::copysign(std::sqrt(0.5 / squares), wxyz[largest]);
  Pixel pixel{};
  pixel[3] = std::uint8_t(252 + largest);
  for (std::size_t i = 0, to = 0; i < 4; ++i)
    if (i != largest) pixel[to++] = byte_of_part(wxyz[i] * factor + 0.5);
  return pixel;
}

Codebook codebook_of(const std::vector<vec3>& vectors) {
  std::vector<Occurrence> numbers;
  numbers.reserve(3 * vectors.size());
  for (const vec3& v : vectors)
    for (int c = 0; c < 3; ++c) numbers.push_back({v[c]});
  return Codebook::of(std::move(numbers));
}

}  // namespace

MeanEncoder::MeanEncoder(const Scene& scene)
    : least_(std::numeric_limits<double>::infinity()), most_(-std::numeric_limits<double>::infinity()) {
  for (const vec3& mean : scene.means)
    for (int axis = 0; axis < 3; ++axis) {
      least_[axis] = std::min(least_[axis], double(mean[axis]));
      most_[axis] = std::max(most_[axis], double(mean[axis]));
    }
  for (int axis = 0; axis < 3; ++axis) {
    least_[axis] = signed_logarithm(least_[axis]);
    most_[axis] = signed_logarithm(most_[axis]);
  }
}

long MeanEncoder::number(float coordinate, int axis) const {
  const double range = most_[axis] - least_[axis];
  return range > 0 ? std::lround((signed_logarithm(coordinate) - least_[axis]) / range * 65535) : 0;
}

RgbaImage MeanEncoder::image(const Scene& scene, Order order, int shift) const {
  return image_of(order, [&](std::uint32_t i) {
    Pixel pixel{0, 0, 0, 255};
    for (int axis = 0; axis < 3; ++axis)
      pixel[std::size_t(axis)] = std::uint8_t(number(scene.means[i][axis], axis) >> shift & 0xff);
    return pixel;
  });
}

vec3 MeanEncoder::stored(const vec3& mean) const {
  const dvec3 step = (most_ - least_) / 65535.0;
  vec3 result;
  for (int axis = 0; axis < 3; ++axis)
    result[axis] = float(signed_exponential(least_[axis] + step[axis] * double(number(mean[axis], axis))));
  return result;
}

Codebook scale_codebook(const Scene& scene) {
  std::vector<Occurrence> numbers;
  numbers.reserve(3 * scene.size());
  for (const vec3& scale : scene.scales)
    for (int axis = 0; axis < 3; ++axis)
      if (scale[axis] > 0) numbers.push_back({log_of_scale(scale[axis])});
  if (numbers.size() == 3 * scene.size()) return Codebook::of(std::move(numbers));
  // A scale of 0 is exact, and the others are not averaged with it.
  Codebook book = Codebook::of(std::move(numbers), 255);
  book.prepend(log_of_scale(0));
  return book;
}

Codebook colour_codebook(const Scene& scene) { return codebook_of(scene.sh0); }

Codebook palette_codebook(const Palette& palette) {
  std::vector<float> times(palette.size());
  for (const std::uint32_t label : palette.labels) ++times[label];
  std::vector<Occurrence> numbers;
  numbers.reserve(palette.colours.size());
  for (std::size_t i = 0; i < palette.colours.size(); ++i)
    if (times[i / palette.width] > 0) numbers.push_back({palette.colours[i], times[i / palette.width]});
  return Codebook::of(std::move(numbers));
}

void measure_sog(const Scene& scene, const MeanEncoder& means, const Codebook& scales,
                 const Codebook& colours, LossMeter& losses) {
  std::array<float, 256> scale_of;
  for (std::size_t byte = 0; byte < scale_of.size(); ++byte)
    scale_of[byte] = float(std::exp(double(scales.values()[byte])));
  for_parts(scene.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      vec3 scale, colour;
      for (int axis = 0; axis < 3; ++axis) {
        scale[axis] = scale_of[scales.byte_of(log_of_scale(scene.scales[i][axis]))];
        colour[axis] = colours.values()[colours.byte_of(scene.sh0[i][axis])];
      }
      losses.add_position(i, means.stored(scene.means[i]));
      losses.add_scales(i, scale);
      losses.add_colour(i, colour);
      losses.add_opacity(i, float(byte_of_part(scene.opacities[i])) / 255);
    }
  });
}

RgbaImage scale_image(const Scene& scene, Order order, const Codebook& codebook) {
  return image_of(order, [&](std::uint32_t i) {
    const auto byte = [&](float scale) { return codebook.byte_of(log_of_scale(scale)); };
    const vec3& scale = scene.scales[i];
    return Pixel{byte(scale.x), byte(scale.y), byte(scale.z), 255};
  });
}

RgbaImage rotation_image(const Scene& scene, Order order) {
  return image_of(order, [&](std::uint32_t i) { return rotation_pixel(scene.rotations[i]); });
}

RgbaImage colour_image(const Scene& scene, Order order, const Codebook& codebook) {
  return image_of(order, [&](std::uint32_t i) {
    const vec3& colour = scene.sh0[i];
    return Pixel{codebook.byte_of(colour.x), codebook.byte_of(colour.y), codebook.byte_of(colour.z),
                 byte_of_part(scene.opacities[i])};
  });
}

RgbaImage label_image(const Palette& palette, Order order) {
  return image_of(order, [&](std::uint32_t i) {
    const std::uint32_t label = palette.labels[i];
    return Pixel{std::uint8_t(label & 0xff), std::uint8_t(label >> 8), 0, 255};
  });
}

RgbaImage palette_image(const Palette& palette, const Codebook& codebook) {
  constexpr std::size_t each_row = 64;
  const std::size_t coefficients = palette.width / 3;
  RgbaImage image;
  image.width = each_row * coefficients;
  image.height = (palette.size() + each_row - 1) / each_row;
  image.bytes.resize(4 * image.width * image.height, 255);
  for (std::size_t i = 0; i < palette.colours.size(); ++i)
    image.bytes[i / 3 * 4 + i % 3] = codebook.byte_of(palette.colours[i]);
  return image;
}

}  // namespace swiftgs::io
