// SPDX-License-Identifier: Apache-2.0
#include "draw/plane_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include <swiftgs/tools/split_mix.hpp>

namespace swiftgs::cli {

float DepthRange::part(float depth) const {
  return high > low ? std::log(depth / low) / std::log(high / low) : 0.0f;
}

float DepthRange::depth(float part) const { return low * std::pow(high / low, part); }

vec3 false_colour(float part) {
  constexpr int last = 4;
  const vec3 stops[last + 1] = {
      {0.15f, 0.1f, 0.45f}, {0.1f, 0.4f, 0.75f}, {0.1f, 0.7f, 0.6f}, {0.55f, 0.85f, 0.3f}, {1, 0.95f, 0.3f}};
  const float at = std::clamp(part, 0.0f, 1.0f) * last;
  const int stop = std::min(int(at), last - 1);
  return stops[stop] + (at - float(stop)) * (stops[stop + 1] - stops[stop]);
}

namespace {

/// The values between which all but the least and the largest hundredth of those above 0 lie.
std::optional<DepthRange> range_of(std::vector<float> values, int length_power) {
  std::erase_if(values, [](float value) { return !(value > 0); });
  if (values.empty()) return std::nullopt;
  const auto value_at = [&](std::size_t i) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(i), values.end());
    return values[i];
  };
  const float low = value_at(values.size() / 100);
  return DepthRange{low, value_at(values.size() - 1 - values.size() / 100), length_power};
}

vec3 colour_of_normal(const float* sum) {
  const vec3 n(sum[0], sum[1], sum[2]);
  const float length = std::sqrt(dot(n, n));
  return length > 0 ? 0.5f * (n / length + 1.0f) : vec3(0);
}

vec3 colour_of_id(std::uint32_t id) {
  if (id == no_gaussian) return vec3(0);
  SplitMix64 random(id);
  const auto channel = [&] { return float(0.25 + 0.75 * random.uniform()); };
  const float red = channel(), green = channel();
  return {red, green, channel()};
}

/// Sets each pixel of `picture` to f(pixel).
template <class F>
void paint(Frame& picture, const F& f) {
  picture.colour.resize(3 * picture.pixels());
  for (std::size_t pixel = 0; pixel < picture.pixels(); ++pixel) {
    const vec3 colour = f(pixel);
    for (int c = 0; c < 3; ++c) picture.colour[3 * pixel + std::size_t(c)] = colour[c];
  }
}

}  // namespace

PlanePicture picture_of_plane(const Frame& frame) {
  PlanePicture shown;
  for_each_plane(
      [&]<class Value>(std::size_t channels, const std::vector<Value>& values, const PlaneRow& row) {
        const std::string_view name = row.name;
        if (values.empty() || name == "colour" || name == "features") return;
        Frame& picture = shown.picture;
        picture.width = frame.width, picture.height = frame.height;
        if constexpr (std::is_same_v<Value, std::uint32_t>) {
          paint(picture, [&](std::size_t pixel) { return colour_of_id(values[pixel]); });
        } else if (channels == 3) {
          paint(picture, [&](std::size_t pixel) { return colour_of_normal(&values[3 * pixel]); });
        } else if (row.length_power == 0) {
          paint(picture, [&](std::size_t pixel) { return vec3(values[pixel]); });
        } else {
          shown.range = range_of(values, row.length_power);
          paint(picture, [&](std::size_t pixel) {
            return values[pixel] > 0 ? false_colour(shown.range->part(values[pixel])) : vec3(0);
          });
        }
      },
      frame, plane_table);
  return shown;
}

}  // namespace swiftgs::cli
