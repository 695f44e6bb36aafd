// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The small scene that the bytes of an input stand for. Every input stands for one, and bytes that are
/// missing are 0.
///
/// A number takes two bytes, from the low end of its range at -32768 to the high end at 32767, mostly in
/// steps of equal ratio. Zeros stand for the middle, so an input of zeros is a scene like any other: a round
/// splat in the middle of the image. `header_size` bytes make the camera, and every `gaussian_size` bytes
/// after them a Gaussian, 16 at most. All ranges lie within the limits of docs/conventions.md.
///
/// Byte i of the seed `LENGTH_STEP` is i * STEP modulo 256.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>

#include "hard_frames/case.hpp"

namespace swiftgs::fuzz {

inline constexpr std::size_t header_size = 32, gaussian_size = 54, max_gaussians = 16;

/// Bounds the half angle of the view and the obliqueness of its axis. This far from the axis every long
/// Gaussian shows as a line through the principal point, which no float of the scene turns.
inline constexpr double max_tangent = 4096;

/// Reads numbers off the bytes of an input.
class Numbers {
 public:
  Numbers(const std::uint8_t* begin, std::size_t size) : at_(begin), end_(begin + size) {}

  bool ended() const { return at_ == end_; }
  std::uint8_t byte() { return ended() ? std::uint8_t(0) : *at_++; }
  /// In [-1, 1).
  double fraction() {
    const unsigned low = byte(), high = byte();
    return double(std::int16_t(std::uint16_t(low | high << 8))) / 32768;
  }
  double in(double low, double high) { return 0.5 * (low + high) + 0.5 * (high - low) * fraction(); }
  double scale(double low, double high) { return std::exp2(in(std::log2(low), std::log2(high))); }
  /// Of either sign, from 2^-30 of `largest` to `largest`; 0 for 0.
  double signed_scale(double largest) {
    const double f = fraction();
    return f == 0 ? 0 : std::copysign(largest * std::exp2(30 * (std::abs(f) - 1)), f);
  }
  void skip_to(const std::uint8_t* to) { at_ = std::min(to, end_); }
  const std::uint8_t* at() const { return at_; }
  const std::uint8_t* after(std::size_t count) const {
    return at_ + std::min(count, std::size_t(end_ - at_));
  }

 private:
  const std::uint8_t *at_, *end_;
};

/// Camera, conventions and background; the degree of `scene`.
inline void read_header(Numbers& numbers, StressCase& out) {
  const unsigned flags = numbers.byte(), more = numbers.byte();
  if (flags & 1) out.conventions = Conventions::inria(), out.conventions.footprint = {};
  out.conventions.antialiased = flags & 2;
  out.scene.sh_degree = flags & 4 ? 1 : 0;
  Camera& camera = out.camera;
  camera.width = 32 - numbers.byte() % 32, camera.height = 24 - numbers.byte() % 24;
  const double least_focal = 0.5 * camera.width / max_tangent;
  camera.fx = camera.fy = numbers.scale(least_focal, max_focal_length);
  const double uneven = numbers.scale(1.0 / 64, 64);
  if (flags & 8) camera.fy = std::clamp(camera.fx * uneven, least_focal, max_focal_length);
  const double far_x = numbers.signed_scale(std::min(0.99 * max_principal_point, max_tangent * camera.fx));
  const double far_y = numbers.signed_scale(std::min(0.99 * max_principal_point, max_tangent * camera.fy));
  camera.cx = 0.5 * camera.width, camera.cy = 0.5 * camera.height;
  if (flags & 16) camera.cx += far_x, camera.cy += far_y;
  const double blur = numbers.scale(0x1p-30, 0x1p10);
  if (flags & 32) out.conventions.blur = more & 1 ? 0 : float(blur);
  const double yaw = numbers.in(-3, 3), pitch = numbers.in(-1.2, 1.2);
  if (flags & 64)
    camera.rotation =
        look_at(dvec3(0), dvec3(std::sin(yaw), std::tan(pitch), std::cos(yaw)), dvec3(0.1, -1, 0.2), 1, 1, 1)
            .rotation;
  for (int k = 0; k < 3; ++k) {
    const double moved = numbers.signed_scale(1e6);
    if (flags & 128) camera.translation[k] = moved;
  }
  for (int k = 0; k < 3; ++k) out.background[k] = 0.25f + 0.25f * float(std::int8_t(numbers.byte())) / 128;
}

/// Reads a Gaussian and adds it. Its place and its sizes are those that the camera sees.
inline void read_gaussian(Numbers& numbers, StressCase& out) {
  const Camera& camera = out.camera;
  const unsigned flags = numbers.byte(), more = numbers.byte();
  stress::Gaussian g;
  const double z = numbers.scale(0x1p-8, 0x1p24);
  // In braces, since those call from left to right with every compiler.
  dvec3 pixel{numbers.in(-0.5, 1.5) * camera.width, numbers.in(-0.5, 1.5) * camera.height, 0};
  const double far_x = numbers.signed_scale(1e7), far_y = numbers.signed_scale(1e7);
  if (flags & 1) pixel.x += far_x;
  if (flags & 2) pixel.y += far_y;
  const dvec3 seen((pixel.x - camera.cx) * z / camera.fx, (pixel.y - camera.cy) * z / camera.fy, z);
  for (int k = 0; k < 3; ++k) g.mean[k] = float(detail::dot(camera.rotation[k], seen - camera.translation));
  for (int k = 0; k < 3; ++k) {
    const double side = numbers.scale(0x1p-24, 0x1p24) * z / std::sqrt(camera.fx * camera.fy);
    g.scale[k] = flags & 4u << k ? 0 : float(side);
  }
  const double w = 1 + numbers.fraction(), x = numbers.fraction(), y = numbers.fraction();
  const double v = numbers.fraction(), length = std::sqrt(w * w + x * x + y * y + v * v);
  const double stretch = numbers.in(0.7, 1.3) / std::max(length, 1e-6);
  const double by = flags & 32 ? stretch : 1 / std::max(length, 1e-6);
  g.rotation = {float(w * by), float(x * by), float(y * by), float(v * by)};
  g.opacity = float(numbers.scale(0x1p-9, 1));
  if (flags & 64) g.opacity = 1;
  for (int k = 0; k < 3; ++k) g.rgb[k] = float(numbers.in(-0.25, 1.75));
  stress::add(out.scene, g);
  // Some share their centre with the Gaussian before: their depths are equal.
  const std::size_t i = out.scene.size() - 1, rest = 3 * std::size_t(sh_rest_count(out.scene.sh_degree));
  if (more & 1 && i > 0) out.scene.means[i] = out.scene.means[i - 1];
  for (std::size_t k = 0; k < 9; ++k) {
    const double harmonic = numbers.signed_scale(0.1);
    if (k < rest) out.scene.sh_rest[i * rest + k] = float(harmonic);
  }
}

inline StressCase ratio_case(const std::uint8_t* data, std::size_t size) {
  StressCase out;
  Numbers numbers(data, size);
  const std::uint8_t* next = numbers.after(header_size);
  read_header(numbers, out);
  do {
    // Parts of fixed size: a changed byte of one Gaussian changes no other.
    numbers.skip_to(next), next = numbers.after(gaussian_size);
    read_gaussian(numbers, out);
  } while (next != data + size && out.scene.size() < max_gaussians);
  return out;
}

/// Writes the scene to stderr.
inline void print(const StressCase& drawn) {
  const Camera& c = drawn.camera;
  const Conventions k = as_trained(drawn.conventions, drawn.scene.model);
  std::fprintf(stderr,
               "%dx%d f %.9g %.9g c %.9g %.9g t %.9g %.9g %.9g blur %g antialiased %d near %g sh %d\n",
               c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.translation.x, c.translation.y, c.translation.z,
               double(*k.blur), int(*k.antialiased), double(k.near_plane), drawn.scene.sh_degree);
  for (std::size_t i = 0; i < drawn.scene.size(); ++i) {
    const vec3 m = drawn.scene.means[i], s = drawn.scene.scales[i];
    const Quaternion q = drawn.scene.rotations[i];
    std::fprintf(stderr,
                 "mean %.9g %.9g %.9g scale %.9g %.9g %.9g rotation %.9g %.9g %.9g %.9g opacity %.9g\n",
                 double(m.x), double(m.y), double(m.z), double(s.x), double(s.y), double(s.z), double(q.w),
                 double(q.x), double(q.y), double(q.z), double(drawn.scene.opacities[i]));
  }
}

}  // namespace swiftgs::fuzz
