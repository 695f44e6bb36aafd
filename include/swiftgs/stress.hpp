// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How exact a frame can be in float: the float64 reference, how far the rounding of the scene itself moves
/// each of its values, and how far a value may jump where a decision stands on the edge.
/// A judge of renderers on frames that are hard for float arithmetic. To test a renderer of your own, draw a
/// scene with it, and `judge` its frame by `render_conditioned` of the same scene.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include <swiftgs/frame.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/srgb.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

namespace swiftgs {

/// How a rasterizer works out the exponent s of a splat.
enum class ExponentRepresentation {
  factor,       ///< a sum of two squares from the factor: `PerPixel`, `FloatCholesky`
  float_split,  ///< three terms that may cancel, in float: `FloatSplit`
  half_split,   ///< the same, stored as half, skipped where rounding makes it negative: `HalfSplit`
};

inline constexpr std::size_t exponent_representations = 3;

/// The representation of the rasterizer called `name`, as in a renderer's name.
inline ExponentRepresentation exponent_representation_named(std::string_view name) {
  if (name.find("half-split") != std::string_view::npos) return ExponentRepresentation::half_split;
  if (name.find("float-split") != std::string_view::npos) return ExponentRepresentation::float_split;
  return ExponentRepresentation::factor;
}

/// The reference and what may be asked of a float renderer that draws the same.
struct ConditionedFrame {
  ReferenceFrame frame;                                     ///< without counts
  std::vector<double> colour_move, alpha_move, depth_move;  ///< as in `frame`: largest move in the trials

  /// @shape{height, width} Ambiguous weight for each exponent representation: of splats whose test may go
  /// either way, of what lies behind a stop that may come a splat earlier or later, and of alphas as far as
  /// the representation may err. 0 in pixels that are not ambiguous.
  std::array<std::vector<double>, exponent_representations> ambiguous;

  ColourSpace colours = ColourSpace::srgb;  ///< in which colours are blended
  double colour_span = 0;                   ///< largest difference of two colours in it, background included
  double peak = 0;                          ///< largest magnitude in `frame.colour`
  double depth_span = 0;                    ///< largest depth

  /// How far a value of `frame.colour` may be off where `weight` is ambiguous. The sRGB curve is steepest at
  /// black, so light changes the encoded value most there.
  double colour_change(double weight) const {
    const double change = weight * colour_span;
    return colours == ColourSpace::linear ? double(to_srgb(float(change))) : change;
  }
};

/// What moves in the trials of `render_conditioned`.
struct StressTrials {
  std::uint64_t seed = 1;   ///< decides alone which numbers move up, down or not at all
  bool scene_only = false;  ///< what renderers store of splats does not move
};

/// Renders placed scenes as `render_reference` does, six more times with every float of them, and the stored
/// mean and factor of every splat, moved by up to a unit in its last place, and finds where decisions are
/// ambiguous. Clips decide of the means as they are.
/// Throws `InvalidArgument` as `render_reference` does, and where `conventions` are not valid or
/// measure depth along the ray.
SWIFTGS_API ConditionedFrame render_conditioned(Span<const ReferenceScene> scenes, const Camera& camera,
                                                const Conventions& conventions, dvec3 background = dvec3(0),
                                                const StressTrials& trials = {}, int threads = 0,
                                                Span<const float> occluder = {});
/// The same of a scene alone, where it stands by itself.
inline ConditionedFrame render_conditioned(const Scene& scene, const Camera& camera,
                                           const Conventions& conventions, dvec3 background = dvec3(0),
                                           const StressTrials& trials = {}, int threads = 0,
                                           Span<const float> occluder = {}) {
  const ReferenceScene alone{scene};
  return render_conditioned({&alone, 1}, camera, conventions, background, trials, threads, occluder);
}

/// How far a frame is from the reference, measured by what float can do.
///
/// The **strict normalised error** of a value is its error over (its largest move in the trials + what
/// rounding it once costs, 2^-23 max(|value|, peak / 16)). Up to 10 a renderer is about as good as float can
/// be; from 100 on digits were thrown away. Where decisions are ambiguous, what they may change is taken off
/// the error first.
struct StressVerdict {
  double strict_normalised_error = 0;  ///< largest, of colour and transmittance
  double normalised_error = 0;         ///< the same beyond what the exponent representation is allowed to err
  double normalised_depth_error = 0;   ///< `normalised_error` of depth
  double psnr_db = 0;                  ///< of colour, for a peak of 1, or the reference's where that is more
  double max_abs = 0;                  ///< of colour
  double ambiguity = 0;                ///< largest weight that the representation leaves open in a pixel
  double allowed = 0;           ///< largest part of that which is due to the representation's error alone
  double judged = 1;            ///< share of pixels of which it leaves less than the whole weight open
  std::uint64_t flips = 0;      ///< pixels where an ambiguous decision fell out the other way
  std::size_t worst_pixel = 0;  ///< of `strict_normalised_error`
};

namespace detail {

/// Normalised errors of one plane.
struct PlaneJudge {
  double peak;  ///< largest magnitude of its values

  /// Normalised error of a value that should be `expected`, which ambiguous decisions may move by `change`.
  double normalised(double value, double expected, double move, double change) const {
    const double error = std::abs(value - expected);
    if (!(error <= std::numeric_limits<double>::max())) return std::numeric_limits<double>::infinity();
    const double rounding = 0x1p-23 * std::max(std::abs(expected), peak / 16);
    const double beyond = error - change;
    return beyond > 0 ? beyond / (move + rounding) : 0;
  }
};

}  // namespace detail

/// Judges `frame`, of the reference's size; its alpha and depth too where it has them. Its renderer works out
/// exponents in `representation`.
inline StressVerdict judge(const ConditionedFrame& reference, const Frame& frame,
                           ExponentRepresentation representation) {
  const detail::PlaneJudge colour{reference.peak}, transmittance{1};
  const std::vector<double>& decisions = reference.ambiguous[std::size_t(ExponentRepresentation::factor)];
  const std::vector<double>& allowed = reference.ambiguous[std::size_t(representation)];
  StressVerdict out;
  const std::size_t pixels = reference.frame.alpha.size();
  const auto open =
      std::count_if(allowed.begin(), allowed.end(), [](double weight) { return !(weight < 1); });
  if (pixels > 0) out.judged = 1 - double(open) / double(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    const double covered = reference.frame.alpha[i];
    // Worst strict normalised error of the pixel's values, beyond a weight that may change hands.
    const auto error = [&](double ambiguous) {
      double worst = 0;
      for (std::size_t v = 3 * i; v < 3 * i + 3; ++v)
        worst =
            std::max(worst, colour.normalised(double(frame.colour[v]), reference.frame.colour[v],
                                              reference.colour_move[v], reference.colour_change(ambiguous)));
      // Alpha is 1 - transmittance, and transmittance is what floats hold.
      if (!frame.alpha.empty())
        worst = std::max(worst, transmittance.normalised(1 - double(frame.alpha[i]), 1 - covered,
                                                         reference.alpha_move[i], ambiguous));
      return worst;
    };
    const double of_pixel = error(decisions[i]);
    if (of_pixel > out.strict_normalised_error) out.strict_normalised_error = of_pixel, out.worst_pixel = i;
    out.normalised_error =
        std::max(out.normalised_error, allowed[i] == decisions[i] ? of_pixel : error(allowed[i]));
    out.flips += decisions[i] > 0 && of_pixel <= 10 && error(0) > 10;
    out.ambiguity = std::max(out.ambiguity, allowed[i]);
    out.allowed = std::max(out.allowed, std::min(1.0, allowed[i]) - std::min(1.0, decisions[i]));
    if (frame.depth.empty() || covered == 0) continue;
    // Depth is divided by alpha: where little is covered, the rounding of transmittance is much of both.
    const double z = reference.frame.depth[i], ambiguous = allowed[i] / std::max(covered - allowed[i], 1e-9);
    const detail::PlaneJudge depth{16 * z / covered};
    out.normalised_depth_error = std::max(out.normalised_depth_error,
                                          depth.normalised(double(frame.depth[i]), z, reference.depth_move[i],
                                                           ambiguous * reference.depth_span));
  }
  out.psnr_db = psnr(frame.colour, reference.frame.colour, std::max(1.0, reference.peak));
  out.max_abs = max_abs_difference(frame.colour, reference.frame.colour);
  return out;
}

}  // namespace swiftgs
