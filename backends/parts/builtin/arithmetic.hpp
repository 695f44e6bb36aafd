// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Arithmetic of the built-in scene. The sine and the power of two are made of IEEE operations alone, because
/// those of the system differ in the last bit from one library to the next, and the scene must not.

#include <cmath>
#include <cstdint>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/tools/split_mix.hpp>

namespace swiftgs::builtin {

/// sin(2 pi t), within 1e-9. Angles of this scene are in turns, so that reducing them is exact.
inline double sin_turns(double t) {
  t -= std::floor(t + 0.5);
  if (t > 0.25) t = 0.5 - t;
  if (t < -0.25) t = -0.5 - t;
  const double x = 6.283185307179586 * t, s = x * x;
  const double tail = s * (1.0 / 362880 - s * (1.0 / 39916800 - s / 6227020800.0));
  return x * (1 - s * (1.0 / 6 - s * (1.0 / 120 - s * (1.0 / 5040 - tail))));
}

inline double cos_turns(double t) { return sin_turns(t + 0.25); }

/// 2^x, relative error below 1e-9.
inline double power_of_two(double x) {
  const double whole = std::floor(x + 0.5), y = (x - whole) * 0.6931471805599453;
  double sum = 1;
  for (int k = 9; k > 0; --k) sum = 1 + y * sum / k;
  return std::ldexp(sum, int(whole));
}

inline double dot(const dvec3& a, const dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline dvec3 cross(const dvec3& a, const dvec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const dvec3& v) { return std::sqrt(dot(v, v)); }
inline dvec3 unit(const dvec3& v) { return v / length(v); }
inline dvec3 mix(const dvec3& a, const dvec3& b, double t) { return a + (b - a) * t; }
inline double clamp01(double x) { return x < 0 ? 0 : x > 1 ? 1 : x; }

/// 0 below `from`, 1 above `to`, smooth between them.
inline double smooth_step(double from, double to, double x) {
  const double t = clamp01((x - from) / (to - from));
  return t * t * (3 - 2 * t);
}

/// A point `height` above the ground: the scene's y axis points down.
inline dvec3 at(double x, double height, double z) { return {x, -height, z}; }

/// Scrambles 64 bits.
inline std::uint64_t scramble(std::uint64_t x) { return SplitMix64::scrambled(x); }

/// Random numbers of one Gaussian. Each has its own sequence, so none depends on how many came before.
class Random {
 public:
  Random(std::uint64_t stream, std::uint64_t index) : bits_(scramble(scramble(stream) + index)) {}

  /// In [0, 1).
  double uniform() { return bits_.uniform(); }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  /// Mean 0, variance 1, within +-3.5: a sum of four uniform numbers.
  double bell() {
    double sum = -2;
    for (int k = 0; k < 4; ++k) sum += uniform();
    return sum * 1.7320508075688772;
  }
  /// Three such numbers. Braces order the calls; arguments in parentheses have no order.
  dvec3 bell3() { return dvec3{bell(), bell(), bell()}; }

 private:
  SplitMix64 bits_;
};

/// The `index`-th point of the R2 sequence, which covers the unit square evenly at any length.
struct SquarePoint {
  double u, v;
  explicit SquarePoint(std::uint64_t index)
      : u(double((0x8000000000000000u + index * 0xc13fa9a902a6328fu) >> 11) * 0x1p-53),
        v(double((0x8000000000000000u + index * 0x91e10da5c79e7b1du) >> 11) * 0x1p-53) {}
};

/// A number in [0, 1) that belongs to a cell of a grid.
inline double cell_value(std::int64_t x, std::int64_t y, std::int64_t z) {
  const std::uint64_t key = std::uint64_t(x) * SplitMix64::step + std::uint64_t(y) * 0xc2b2ae3d27d4eb4fu +
                            std::uint64_t(z) * 0x165667b19e3779f9u;
  return double(scramble(key) >> 11) * 0x1p-53;
}

/// Smooth noise in [0, 1], one feature a unit.
inline double noise(const dvec3& p) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double tx = ease(p.x - fx), ty = ease(p.y - fy), tz = ease(p.z - fz);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const double weight = (i ? tx : 1 - tx) * (j ? ty : 1 - ty) * (k ? tz : 1 - tz);
    sum += weight * cell_value(std::int64_t(fx) + i, std::int64_t(fy) + j, std::int64_t(fz) + k);
  }
  return sum;
}

/// Noise with detail at several sizes, in [0, 1].
inline double layered_noise(dvec3 p, int layers) {
  double sum = 0, weight = 0.5, total = 0;
  for (int layer = 0; layer < layers; ++layer, weight *= 0.5) {
    sum += weight * noise(p), total += weight;
    p = p * 2.03 + dvec3(17.1, 5.7, 31.3);
  }
  return sum / total;
}

}  // namespace swiftgs::builtin
