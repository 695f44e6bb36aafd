// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An oracle for the reference: every Gaussian at every pixel, in long double, with no tiles, no bands and no
/// bounds but the convention's. For each value it bounds what double arithmetic may differ by, and it marks
/// the pixels in which such a difference could turn a decision.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/frame.hpp>
#include <swiftgs/frame/span.hpp>

#include "reference/oracle_gaussian.hpp"

namespace swiftgs::test {

/// A value and what double may differ from it by.
struct Bounded {
  Real value = 0, error = 0;
};

/// The splat of a pixel that something is told about.
struct OraclePick {
  std::uint32_t gaussian = no_gaussian;
  Bounded depth;
  bool sure = true;  ///< no rounding chooses another
};

struct OracleFrame {
  std::vector<Bounded> colour, alpha, depth;  ///< as in `ReferenceFrame`
  std::vector<Bounded> squared_depth, normal, features;
  std::vector<OraclePick> first, median, largest;
  std::vector<bool> sure;  ///< pixels in which no rounding turns a decision
  std::size_t unsure = 0;  ///< the other pixels
  std::uint64_t visible = 0, contributing_pairs = 0, pixels_stopped = 0;
};

/// Squared Mahalanobis distance of a pixel from a splat's mean.
inline Bounded squared_distance_at(const OracleSplat& s, int column, int row) {
  const Real dx = Real(column) + 0.5L - s.x, dy = Real(row) + 0.5L - s.y;
  const Real u = dx / s.l00, v = (dy - s.l10 * u) / s.l11;

  // The reference adds x_weight (dx - shear dy)^2 and y_weight dy^2.
  const SplatDoubt& e = s.doubt;
  const Real along = std::abs(dx - s.shear * dy), up = std::abs(dy);
  const Real y_error = e.position_y + unit * up;
  const Real x_error = e.position_x + unit * std::abs(dx) + std::abs(s.shear) * (y_error + 2 * unit * up) +
                       e.shear * up + 2 * unit * along;
  const Real twice =
      s.x_weight * (x_error * (2 * along + x_error) + (e.x_weight + 4 * unit) * along * along) +
      s.y_weight * (y_error * (2 * up + y_error) + (e.y_weight + 4 * unit) * up * up);
  return {u * u + v * v, twice};
}

/// What a splat's alpha is at a pixel.
inline Bounded alpha_at(const OracleSplat& s, const Bounded& squared_distance) {
  const Real alpha = s.opacity * std::exp(-squared_distance.value / 2);
  const Real relative = squared_distance.error / 2 + s.doubt.opacity + 4 * unit;
  return {alpha, alpha * (relative < 1e-4L ? 1.001L * relative : std::expm1(std::min(relative, Real(1e3))))};
}

/// Blends one pixel. `surely` becomes false where rounding could turn a decision.
class OraclePixel {
 public:
  OraclePixel(const Conventions& conventions, float occluder, int feature_channels)
      : features(std::size_t(feature_channels)), k_(conventions), occluder_(occluder) {}

  /// Offers the next splat; true when it contributed.
  bool offer(const OracleSplat& s, int x, int y) {
    if ((stopped && follows(s)) || !s.footprint.holds(x, y)) return false;
    const Bounded distance = squared_distance_at(s, x, y);
    Bounded alpha = test::alpha_at(s, distance);
    const bool ellipse = k_.footprint == Conventions::Footprint::three_sigma_ellipse;
    const Real beyond = ellipse ? distance.value - 9 : -INFINITY;
    if (alpha.value + alpha.error < k_.alpha_min || beyond > distance.error) return false;
    const Bounded here = depth_at(s, x, y);
    const bool along_ray = k_.depth_at == Conventions::DepthAt::ray;
    const float nearest = along_ray ? float(here.value - here.error) : s.doubt.nearest;
    const float furthest = along_ray ? float(here.value + here.error) : s.doubt.furthest;
    // From here on the splat might show, so every doubt about it counts.
    surely = surely && std::abs(alpha.value - k_.alpha_min) > alpha.error && !s.doubt.drawn &&
             beyond < -distance.error && s.doubt.surely.holds(x, y) && follows(s) &&
             (nearest >= occluder_) == (furthest >= occluder_);
    remember(s);
    if (stopped || !s.drawn || alpha.value < k_.alpha_min || beyond > 0) return false;
    const bool hidden = float(here.value) >= occluder_;
    if (hidden && along_ray) return false;
    alpha.value = std::min(alpha.value, Real(k_.alpha_max));

    const Bounded left{
        light.value * (1 - alpha.value),
        light.error * (1 - alpha.value) + (light.value + light.error) * alpha.error + 2 * unit * light.value};
    surely = surely && std::abs(left.value - k_.stop) > left.error;
    stopped = (k_.stop_at_equal ? left.value <= k_.stop : left.value < k_.stop) || hidden;
    if (stopped) return false;
    const Bounded part{alpha.value * light.value, alpha.error * (light.value + light.error) +
                                                      alpha.value * light.error +
                                                      2 * unit * alpha.value * light.value};
    add(s, here, part);
    take_below(first, 1 - Real(k_.first_alpha), left, s, here);
    take_below(median, 0.5L, left, s, here);
    offer_weight(s, here, part);
    light = left;
    return true;
  }

  Bounded colour[3], light{1, 0}, weight, depth, squared_depth, normal[3];
  std::vector<Bounded> features;
  OraclePick first, median, largest;
  bool stopped = false, surely = true;

 private:
  /// Depth at pixel (x, y); its slope is 0 where depths are those of means.
  static Bounded depth_at(const OracleSplat& s, int x, int y) {
    const Real dx = x + 0.5L - s.x, dy = y + 0.5L - s.y, along_x = s.slope_x * dx, along_y = s.slope_y * dy;
    const Real error = s.doubt.slope * std::hypot(dx, dy) + std::abs(s.slope_x) * s.doubt.position_x +
                       std::abs(s.slope_y) * s.doubt.position_y +
                       8 * unit * (std::abs(along_x) + std::abs(along_y));
    return {s.z + along_x + along_y, s.doubt.z + error};
  }
  /// Whether no rounding moves `s` before a splat that was offered.
  bool follows(const OracleSplat& s) const {
    return s.doubt.nearest > furthest_ || (s.doubt.nearest == furthest_ && s.index > last_);
  }
  void remember(const OracleSplat& s) {
    if (s.doubt.furthest > furthest_) furthest_ = s.doubt.furthest, last_ = s.index;
    if (s.doubt.furthest == furthest_) last_ = std::max(last_, s.index);
  }
  void add(const OracleSplat& s, const Bounded& z, const Bounded& w) {
    const auto accumulate = [&](Bounded& sum, Real value, Real error) {
      sum.value += w.value * value;
      sum.error += w.error * std::abs(value) + w.value * error + unit * std::abs(w.value * value);
      sum.error += unit * std::abs(sum.value);
    };
    for (std::size_t c = 0; c < 3; ++c) accumulate(colour[c], s.colour[c], s.doubt.colour[c]);
    accumulate(depth, z.value, z.error);
    accumulate(squared_depth, z.value * z.value,
               (2 * std::abs(z.value) + z.error) * z.error + unit * z.value * z.value);
    for (std::size_t c = 0; c < 3; ++c) accumulate(normal[c], s.normal[c], s.doubt.normal);
    for (std::size_t c = 0; c < features.size(); ++c) accumulate(features[c], Real(s.features[c]), 0);
    accumulate(weight, 1, 0);
  }
  /// Notes the splat that takes the light below `threshold`.
  void take_below(OraclePick& pick, Real threshold, const Bounded& left, const OracleSplat& s,
                  const Bounded& z) const {
    pick.sure = pick.sure && std::abs(left.value - threshold) > left.error;
    if (light.value >= threshold && left.value < threshold)
      pick.gaussian = std::uint32_t(s.index), pick.depth = z;
  }
  void offer_weight(const OracleSplat& s, const Bounded& z, const Bounded& part) {
    const bool more = part.value > most_.value;
    const Bounded &greater = more ? part : most_, &smaller = more ? most_ : part;
    if (more) largest.gaussian = std::uint32_t(s.index), largest.depth = z;
    next_ = std::max(next_, smaller.value + smaller.error), most_ = greater;
    largest.sure = most_.value - most_.error > next_;
  }

  const Conventions& k_;
  Bounded most_;   ///< weight of the largest
  Real next_ = 0;  ///< most of the others
  Real occluder_;
  float furthest_ = -1;
  std::size_t last_ = 0;
};

/// What `pixel` shows over `background`.
inline void store(OracleFrame& frame, const OraclePixel& pixel, dvec3 background) {
  const Bounded& light = pixel.light;
  for (int c = 0; c < 3; ++c) {
    const Real value = pixel.colour[c].value + light.value * background[c];
    frame.colour.push_back({value, pixel.colour[c].error + light.error * std::abs(background[c]) +
                                       2 * unit * (std::abs(value) + std::abs(background[c]))});
  }
  frame.alpha.push_back({1 - light.value, light.error + unit});
  const Bounded& weight = pixel.weight;
  const auto mean_of = [&](const Bounded& sum) {
    if (!(weight.value > 0)) return Bounded();
    const Real mean = sum.value / weight.value;
    return Bounded{mean,
                   (sum.error + std::abs(mean) * weight.error) / weight.value + 2 * unit * std::abs(mean)};
  };
  frame.depth.push_back(mean_of(pixel.depth));
  frame.squared_depth.push_back(mean_of(pixel.squared_depth));
  frame.normal.insert(frame.normal.end(), pixel.normal, pixel.normal + 3);
  frame.features.insert(frame.features.end(), pixel.features.begin(), pixel.features.end());
  frame.first.push_back(pixel.first), frame.median.push_back(pixel.median);
  frame.largest.push_back(pixel.largest);
  frame.sure.push_back(pixel.surely);
  frame.unsure += !pixel.surely;
  frame.pixels_stopped += pixel.stopped;
}

/// Renders placed scenes of as many features. `occluder`: as of `render_reference`.
inline OracleFrame render_oracle(Span<const ReferenceScene> scenes, const Camera& camera,
                                 const Conventions& conventions, dvec3 background = dvec3(0),
                                 Span<const float> occluder = {}) {
  std::vector<OracleSplat> splats;
  std::size_t number = 0;
  for (const ReferenceScene& placed : scenes)
    for (std::size_t i = 0; i < placed.scene.size(); ++i, ++number)
      if (const auto splat = project_gaussian({placed, i}, number, camera, conventions))
        splats.push_back(*splat);
  std::sort(splats.begin(), splats.end(), [](const OracleSplat& a, const OracleSplat& b) {
    return a.order != b.order ? a.order < b.order : a.index < b.index;
  });

  OracleFrame frame;
  std::vector<bool> seen(splats.size());
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const std::size_t i = std::size_t(y) * std::size_t(camera.width) + std::size_t(x);
      OraclePixel pixel(conventions, occluder.size > 0 ? occluder[i] : INFINITY,
                        scenes[0].scene.feature_channels);
      for (std::size_t n = 0; n < splats.size(); ++n)
        if (pixel.offer(splats[n], x, y)) ++frame.contributing_pairs, seen[n] = true;
      store(frame, pixel, background);
    }
  frame.visible = std::uint64_t(std::count(seen.begin(), seen.end(), true));
  return frame;
}

}  // namespace swiftgs::test
