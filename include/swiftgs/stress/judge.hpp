// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <swiftgs/frame.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference/conditioning.hpp>

namespace swiftgs {

/// How far a frame is from the reference, measured by what float can do.
///
/// The **ratio** of a value is its error over (its largest move in the trials + what rounding costs).
/// Rounding costs 2^-23 max(|value|, peak / 16), times sqrt(layers) / 8 from 64 layers on: a pixel's
/// transmittance is rounded once a layer, which is a random walk. Up to 10 a renderer is about as good as
/// float can be; from 100 on digits were thrown away. Where decisions are loose, what they may change is
/// taken off the error first.
struct StressVerdict {
  double ratio = 0;             ///< largest, of colour and transmittance, beyond what is loose
  double depth_ratio = 0;       ///< the same of depth
  double psnr_db = 0;           ///< of colour, for a peak of 1, or the reference's where that is more
  double max_abs = 0;           ///< of colour
  double loosest = 0;           ///< largest weight that may change hands in a pixel
  std::uint64_t flips = 0;      ///< loose pixels that differ by a ratio above 10
  std::size_t worst_pixel = 0;  ///< of `ratio`
};

namespace stress {

/// Ratios of one plane.
struct PlaneJudge {
  double peak, span;  ///< largest magnitude of its values, largest difference of two colours in it

  /// Ratio of a value that should be `expected`, of which the part `loose` may change hands.
  double ratio(double value, double expected, double move, double loose, std::uint32_t layers) const {
    const double error = std::abs(value - expected);
    if (!(error <= std::numeric_limits<double>::max())) return std::numeric_limits<double>::infinity();
    const double walk = std::max(1.0, std::sqrt(double(layers)) / 8);
    const double rounding = std::ldexp(walk * std::max(std::abs(expected), peak / 16), -23);
    const double beyond = error - loose * span;
    return beyond > 0 ? beyond / (move + rounding) : 0;
  }
};

}  // namespace stress

/// Judges `frame`, of the reference's size; its alpha and depth too where it has them.
inline StressVerdict judge(const ConditionedFrame& reference, const Frame& frame) {
  const stress::PlaneJudge colour{reference.peak, reference.colour_span}, transmittance{1, 1};
  StressVerdict out;
  for (std::size_t i = 0; i < reference.frame.alpha.size(); ++i) {
    const double loose = reference.loose[i], covered = reference.frame.alpha[i];
    const std::uint32_t layers = reference.layers[i];
    double worst = 0, worst_of_all = 0;
    for (std::size_t v = 3 * i; v < 3 * i + 3; ++v) {
      const auto ratio = [&](double taken_off) {
        return colour.ratio(double(frame.colour[v]), reference.frame.colour[v], reference.colour_move[v],
                            taken_off, layers);
      };
      worst = std::max(worst, ratio(loose)), worst_of_all = std::max(worst_of_all, ratio(0));
    }
    // Alpha is 1 - transmittance, and transmittance is what floats hold.
    if (!frame.alpha.empty())
      worst = std::max(worst, transmittance.ratio(1 - double(frame.alpha[i]), 1 - covered,
                                                  reference.alpha_move[i], loose, layers));
    if (worst > out.ratio) out.ratio = worst, out.worst_pixel = i;
    out.flips += loose > 0 && worst_of_all > 10;
    out.loosest = std::max(out.loosest, loose);
    if (frame.depth.empty() || covered == 0) continue;
    // Depth is divided by alpha: where little is covered, the rounding of transmittance is much of both.
    const double z = reference.frame.depth[i];
    const stress::PlaneJudge depth{16 * z / covered, reference.depth_span};
    out.depth_ratio =
        std::max(out.depth_ratio, depth.ratio(double(frame.depth[i]), z, reference.depth_move[i],
                                              loose / std::max(covered - loose, 1e-9), layers));
  }
  const double peak = std::max(1.0, reference.peak);
  const auto relative = [&](const auto& values) {
    std::vector<double> scaled(values.begin(), values.end());
    for (double& value : scaled) value /= peak;
    return scaled;
  };
  out.psnr_db = psnr(relative(frame.colour), relative(reference.frame.colour));
  out.max_abs = max_abs_difference(frame.colour, reference.frame.colour);
  return out;
}

}  // namespace swiftgs
