// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How far rounding moves a frame: trials that move each number, and bounds of each representation's
/// exponent.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/stress.hpp>
#include <swiftgs/tools/split_mix.hpp>

#include "projection.hpp"

namespace swiftgs::reference {

/// Trials of one frame. In each, every number that a renderer reads or keeps as float moves by a rounding
/// error:
/// - every float of the scene moves by up to one unit in its last place;
/// - so do the mean and the factor of every splat as floats unless `StressTrials::scene_only`, because
///   renderers store them, and a long ridge shows it;
/// - what a pixel holds is rounded to float after every layer.
inline constexpr std::size_t trials = 6;

/// Decides, from what it is asked for alone, whether a number moves down, up or not at all in a trial.
class Nudges {
 public:
  explicit Nudges(std::uint64_t seed) : bits_(seed) {}

  float nudged(float value) {
    const int step = next();
    if (step == 0 || !std::isfinite(value)) return value;
    const float to =
        step > 0 ? std::numeric_limits<float>::infinity() : -std::numeric_limits<float>::infinity();
    const float moved = std::nextafter(value, to);
    return std::isfinite(moved) ? moved : value;
  }
  vec3 nudged(vec3 v) { return {nudged(v.x), nudged(v.y), nudged(v.z)}; }

  /// -1, 0 or 1.
  int next() { return int(bits_.bits() % 3) - 1; }

 private:
  SplitMix64 bits_;
};

/// `scene` with every float moved by up to one unit in its last place.
inline Scene nudged(const Scene& scene, std::uint64_t seed) {
  Nudges nudges(seed);
  Scene out = scene;
  for (vec3& v : out.means) v = nudges.nudged(v);
  for (vec3& v : out.scales) v = nudges.nudged(v);
  for (Quaternion& q : out.rotations)
    q = {nudges.nudged(q.w), nudges.nudged(q.x), nudges.nudged(q.y), nudges.nudged(q.z)};
  for (float& v : out.opacities) v = nudges.nudged(v);
  for (vec3& v : out.sh0) v = nudges.nudged(v);
  for (float& v : out.sh_rest) v = nudges.nudged(v);
  return out;
}

/// Distance from |value| to the next float @units{value}
inline double float_ulp(double value) {
  const float magnitude = std::abs(float(value));
  if (!std::isfinite(magnitude)) return 0;
  return double(std::nextafter(magnitude, std::numeric_limits<float>::infinity())) - double(magnitude);
}

/// Cholesky factor in base 2, as `SplatShape` has it.
struct Factor {
  double l0 = 0, l1 = 0, l2 = 0;
};

/// What a pixel needs of a splat, as the scene has it or as a trial has it.
struct SplatNumbers {
  double x = 0, y = 0, x_weight = 0, y_weight = 0, shear = 0;
  double log2_opacity = 0, depth = 0;
  Eigen::Vector3d colour = Eigen::Vector3d::Zero();

  explicit SplatNumbers(const Splat& s)
      : x(s.x),
        y(s.y),
        x_weight(s.x_weight),
        y_weight(s.y_weight),
        shear(s.shear),
        log2_opacity(std::log2(s.opacity)),
        depth(s.depth),
        colour(s.colour) {}

  Factor factor() const {
    const double l0 = std::sqrt(half_log2_e * x_weight);
    return {l0, -l0 * shear, std::sqrt(half_log2_e * y_weight)};
  }
  void set_factor(const Factor& f) {
    x_weight = f.l0 * f.l0 / half_log2_e, y_weight = f.l2 * f.l2 / half_log2_e;
    shear = -f.l1 / f.l0;
  }

  /// Half the squared Mahalanobis distance of a point.
  double sigma(double at_x, double at_y) const {
    const double dy = at_y - y, along = at_x - x - shear * dy;
    return 0.5 * (x_weight * along * along + y_weight * dy * dy);
  }

 private:
  static constexpr double half_log2_e = 0.72134752044448170368;
};

/// Moves what a renderer stores of a splat.
inline void nudge_stored(SplatNumbers& numbers, Nudges& nudges) {
  const auto nudge = [&](double& value) { value += nudges.next() * float_ulp(value); };
  nudge(numbers.x), nudge(numbers.y);
  Factor factor = numbers.factor();
  nudge(factor.l0), nudge(factor.l1), nudge(factor.l2);
  // A factor below what floats hold is one that no renderer stores.
  if (factor.l0 > 0 && factor.l2 > 0) numbers.set_factor(factor);
}

/// Where a footprint that cuts splats keeps one. A splat that is kept or dropped at a pixel where rounding
/// decides is ambiguous there.
class FootprintCut {
 public:
  enum class At { kept, dropped, ambiguously_kept, ambiguously_dropped };

  /// Keeps every pixel.
  FootprintCut() = default;

  /// The square of three standard deviations of `splat`. `ThreeSigmaSquare` computes the larger axis from a
  /// difference of squares, like INRIA's code. A nearly round splat loses half the digits of it, so the axis
  /// may be off by 2^-12 of itself.
  FootprintCut(const Splat& splat, const std::vector<SplatNumbers>& numbers) {
    const double sigmas = three_sigmas(splat.covariance), off = std::ldexp(sigmas, -12);
    double move_x = 0, move_y = 0;
    for (const SplatNumbers& n : numbers) {
      move_x = std::max(move_x, 10 * std::abs(n.x - splat.x));
      move_y = std::max(move_y, 10 * std::abs(n.y - splat.y));
    }
    x_ = Side(splat.x, move_x, sigmas, off), y_ = Side(splat.y, move_y, sigmas, off);
  }

  At at(int x, int y) const {
    const bool kept = x_.exact.has(x) && y_.exact.has(y);
    if (kept) return x_.least.has(x) && y_.least.has(y) ? At::kept : At::ambiguously_kept;
    return x_.most.has(x) && y_.most.has(y) ? At::ambiguously_dropped : At::dropped;
  }

 private:
  struct Pixels {
    double first = -std::numeric_limits<double>::infinity(), last = std::numeric_limits<double>::infinity();
    bool has(int pixel) const { return pixel >= first && pixel < last; }
  };
  struct Side {
    Pixels exact, least, most;

    Side() = default;
    Side(double mean, double move, double sigmas, double off) {
      const SquareSide exactly(mean, sigmas);
      exact = {exactly.first, exactly.last};
      least = {SquareSide(mean + move, sigmas - off).first, SquareSide(mean - move, sigmas - off).last};
      most = {SquareSide(mean - move, sigmas + off).first, SquareSide(mean + move, sigmas + off).last};
    }
  };
  Side x_, y_;
};

/// A splat's factor applied at a point.
struct FactorAt : Factor {
  double dx, dy, u, v;

  FactorAt(const SplatNumbers& n, double x, double y)
      : Factor(n.factor()), dx(x - n.x), dy(y - n.y), u(l0 * (dx - n.shear * dy)), v(l2 * dy) {}
};

/// Largest error of s at a point that the representation makes, beyond the roundings that any float
/// arithmetic makes.
inline double exponent_error(ExponentRepresentation representation, const SplatNumbers& numbers, double x,
                             double y) {
  if (representation == ExponentRepresentation::factor) return 0;
  const FactorAt at(numbers, x, y);
  const double l1 = std::abs(at.l1);
  if (representation == ExponentRepresentation::float_split) {
    const double wide = std::abs(at.u) + 16 * (at.l0 + l1), high = std::abs(at.v) + 16 * at.l2;
    return std::ldexp(wide * wide + high * high, -18);
  }
  // Each of the four stored terms is rounded to 11 bits, or to 2^-25 where it is subnormal; the mixed term is
  // a product of two.
  const double dx = std::abs(at.dx), dy = std::abs(at.dy);
  const double a = at.l0 * at.l0 * dx * dx, c = (l1 * l1 + at.l2 * at.l2) * dy * dy;
  const double b = 2 * at.l0 * l1 * dx, largest_half = 65504;
  if (!(std::max({a, b, c, dy}) <= largest_half)) return std::numeric_limits<double>::infinity();
  return std::ldexp(1.01 * (a + c + 2 * b * dy), -11) + std::ldexp(2 + b + dy, -24);
}

/// Whether a rasterizer evaluates a splat at pixel (x, y) at all: rasterizers skip rows of 16 pixels in which
/// the splat keeps none. Only a representation that may err widely far from the splat needs to know.
inline bool may_be_visited(ExponentRepresentation representation, const SplatNumbers& numbers, int x, int y,
                           const Conventions& k) {
  if (representation != ExponentRepresentation::half_split) return true;
  const double first = 16 * std::floor(x / 16.0) + 0.5, at_y = y + 0.5;
  const FactorAt left(numbers, first, at_y), right(numbers, first + 15, at_y);
  const double nearest = left.u > 0 ? left.u : right.u < 0 ? right.u : 0;
  const double s = nearest * nearest + left.v * left.v;
  const double cutoff = numbers.log2_opacity - std::log2(double(k.alpha_min));
  return s <= 1.001 * std::max(cutoff, 0.0) + 0.001;
}

}  // namespace swiftgs::reference
