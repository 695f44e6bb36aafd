// SPDX-License-Identifier: Apache-2.0

#include "spz_encode.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <swiftgs/edit/origin.hpp>
#include <swiftgs/project/sh.hpp>

#include "scene_encoding.hpp"
#include "spz_content.hpp"

namespace swiftgs::io {
namespace {

double distance_of(const vec3& mean) {
  return double(std::max({std::abs(mean.x), std::abs(mean.y), std::abs(mean.z)}));
}

/// The most bits, up to `most`, with which a coordinate is at most `steps` steps from zero.
int bits_for(double coordinate, double steps, int most) {
  int bits = most;
  while (bits > 0 && std::ldexp(coordinate, bits) > steps) --bits;
  return bits;
}

int bits_of_scene(double farthest) {
  const int fine = bits_for(farthest, 1 << 15, 24);
  return fine >= 12 ? fine : bits_for(farthest, std::nextafter(spz_largest_position + 0.5, 0), 12);
}

}  // namespace

double SpzReach::largest() const { return std::ldexp(spz_largest_position, -fractional_bits); }

SpzReach reach_of(const Scene& scene) {
  double farthest = 0, farthest_of_bulk = 0;
  const swiftgs::detail::Bulk bulk(scene.size(), [&](std::size_t i) { return scene.means[i]; });
  std::vector<std::uint32_t> strays;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const double distance = distance_of(scene.means[i]);
    farthest = std::max(farthest, distance);
    if (bulk.has(scene.means[i]))
      farthest_of_bulk = std::max(farthest_of_bulk, distance);
    else
      strays.push_back(std::uint32_t(i));
  }
  SpzReach reach{.fractional_bits = bits_of_scene(farthest), .middle = bulk.centre()};
  if (strays.size() > scene.size() / 500) return reach;
  const int wanted = bits_of_scene(farthest_of_bulk);
  if (reach.fractional_bits >= std::min(wanted, bits_for(farthest_of_bulk, 1 << 17, 24))) return reach;
  reach.fractional_bits = wanted;
  std::erase_if(strays, [&](std::uint32_t i) { return distance_of(scene.means[i]) <= reach.largest(); });
  reach.beyond = std::move(strays);
  return reach;
}

Scene drawn_in(Scene scene, const SpzReach& reach) {
  const double largest = reach.largest();
  for (const std::uint32_t i : reach.beyond) {
    const dvec3 away = dvec3(scene.means[i]) - reach.middle;
    double part = 1;
    for (int axis = 0; axis < 3; ++axis)
      if (away[axis] != 0)
        part = std::min(part, (std::copysign(largest, away[axis]) - reach.middle[axis]) / away[axis]);
    scene.means[i] = vec3(glm::clamp(reach.middle + part * away, -largest, largest));
    scene.scales[i] = vec3(part * dvec3(scene.scales[i]));
  }
  return scene;
}

namespace {

/// Writes values as they come, and counts those that are clamped.
class ByteEncoder {
 public:
  explicit ByteEncoder(std::byte* to) : to_(to) {}

  /// The byte nearest to `value`, which may be infinite.
  void add(float value) {
    clamped_ += !(value > -0.5f && value < 255.5f);
    *to_++ = std::byte(std::clamp(value + 0.5f, 0.0f, 255.0f));
  }

  /// The 24-bit number nearest to `value`.
  void add_position(double value) {
    clamped_ += std::abs(value) >= spz_largest_position + 0.5;
    add_little_endian(
        std::uint32_t(std::lrint(std::clamp(value, -spz_largest_position, spz_largest_position))), 3);
  }

  void add_little_endian(std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) *to_++ = std::byte(value >> 8 * i & 255);
  }

  std::uint64_t clamped() const { return clamped_; }

 private:
  std::byte* to_;
  std::uint64_t clamped_ = 0;
};

/// Leaves one of x, y, z, w out, which must be the largest or nearly so, and makes it positive: two bits name
/// it. The others take ten bits each, first to last from high bits to low: a sign and how many 511ths of the
/// root of 1/2.
std::uint32_t pack_all_but(std::uint32_t largest, const std::array<float, 4>& xyzw) {
  std::uint32_t packed = largest;
  for (std::uint32_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const float steps = 511 * std::sqrt(2.0f) * std::abs(xyzw[i]);
    const std::uint32_t magnitude = std::min(std::uint32_t(steps + 0.5f), 511u);
    const bool negative = magnitude != 0 && (xyzw[i] < 0) != (xyzw[largest] < 0);
    packed = packed << 10 | std::uint32_t(negative) << 9 | magnitude;
  }
  return packed;
}

/// The square of how far a packed rotation is from what it stands for.
float error_of(std::uint32_t packed, const Quaternion& q) {
  const Quaternion found = decode_smallest_three(packed);
  const float dot = q.w * found.w + q.x * found.x + q.y * found.y + q.z * found.z, sign = dot < 0 ? -1 : 1;
  const float w = q.w - sign * found.w, x = q.x - sign * found.x, y = q.y - sign * found.y,
              z = q.z - sign * found.z;
  return w * w + x * x + y * y + z * z;
}

/// Leaves the largest component out, as all writers do. Once decoded it may be a little smaller than another:
/// a rotation that was decoded is encoded as it was all the same.
std::uint32_t smallest_three(const Quaternion& rotation) {
  const Quaternion q = normalised(rotation.w, rotation.x, rotation.y, rotation.z);
  const std::array<float, 4> xyzw = {q.x, q.y, q.z, q.w};
  std::uint32_t largest = 0;
  for (std::uint32_t i = 1; i < 4; ++i)
    if (std::abs(xyzw[i]) > std::abs(xyzw[largest])) largest = i;
  constexpr float little = 0.004f, rounding_of_float = 1e-11f;
  std::uint32_t best = pack_all_but(largest, xyzw);
  for (std::uint32_t i = 0; i < 4; ++i) {
    if (i == largest || std::abs(xyzw[i]) < std::abs(xyzw[largest]) - little) continue;
    const std::uint32_t other = pack_all_but(i, xyzw);
    const float error = error_of(other, q);
    if (error < rounding_of_float && error < error_of(best, q)) best = other;
  }
  return best;
}

/// Rounds coefficients to every 8th value of a byte in band 1, and to every 16th above, as all writers of
/// SPZ do: the format's 8 bits would double a file of degree 3.
std::uint64_t encode_harmonics(const Scene& scene, const AxisFlip& flip, std::size_t begin, std::size_t end,
                               std::byte* to) {
  constexpr std::size_t most = 3 * sh_rest_count(max_sh_degree);
  const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  const auto signs = flip.sh_signs();
  std::array<float, most> to_bytes{}, to_steps{};
  std::array<int, most> step{};
  for (std::size_t k = 0; k < most; ++k) {
    step[k] = k / 3 < std::size_t(sh_rest_count(1)) ? 8 : 16;
    to_bytes[k] = 128 * signs[k / 3];
    to_steps[k] = 1.0f / float(step[k]);
  }
  std::uint64_t clamped = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const float* from = scene.sh_rest.data() + i * rest;
    int outside = 0;
    for (std::size_t k = 0; k < rest; ++k) {
      const float value = to_bytes[k] * from[k] + 128;
      outside += !(value > -0.5f && value < 255.5f);
      // Rounded by cutting off, which needs a number that is not negative.
      const int steps = int(std::clamp(value, 0.0f, 255.0f) * to_steps[k] + 0.5f);
      to[k] = std::byte(std::min(steps * step[k], 255));
    }
    to += rest;
    clamped += std::uint64_t(outside);
  }
  return clamped;
}

}  // namespace

std::uint64_t encode_spz(const Scene& scene, const SpzEncoding& encoding, SpzAttribute attribute,
                         std::size_t begin, std::size_t end, std::byte* to) {
  if (attribute == spz_sh) return encode_harmonics(scene, encoding.flip, begin, end, to);
  ByteEncoder out(to);
  const double positions = std::ldexp(1.0, encoding.fractional_bits);
  for (std::size_t i = begin; i < end; ++i) {
    if (attribute == spz_alphas) out.add(255 * scene.opacities[i]);
    if (attribute == spz_rotations)
      out.add_little_endian(smallest_three(encoding.flip.rotation(scene.rotations[i])), 4);
    for (int axis = 0; axis < 3; ++axis) {
      if (attribute == spz_positions)
        out.add_position(positions * double(encoding.flip.position(scene.means[i])[axis]));
      if (attribute == spz_colours) out.add(scene.sh0[i][axis] * (0.15f * 255) + 127.5f);
      if (attribute == spz_scales) out.add((log_of_scale(scene.scales[i][axis]) + 10) * 16);
    }
  }
  return out.clamped();
}

void measure_spz(const SpzHeader& header, const AxisFlip& flip, SpzAttribute attribute, std::size_t begin,
                 std::size_t end, const std::byte* from, LossMeter& losses) {
  static const SpzTables tables;
  const std::size_t size = spz_sizes(header)[attribute];
  for (std::size_t i = begin; i < end; ++i, from += size) {
    if (attribute == spz_positions) losses.add_position(i, flip.position(decode_spz_position(header, from)));
    if (attribute == spz_alphas) losses.add_opacity(i, decode_spz_opacity(from));
    if (attribute == spz_colours) losses.add_colour(i, SpzTables::three(tables.colour, from));
    if (attribute == spz_scales) losses.add_scales(i, SpzTables::three(tables.scale, from));
  }
}

}  // namespace swiftgs::io
