// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/stress.hpp>
#include <swiftgs/tools/parallel.hpp>

#include "rendering.hpp"
#include "variation.hpp"
#include "varied_splats.hpp"

namespace swiftgs {
namespace reference {
namespace {

/// What an exponent representation leaves open in a pixel.
struct Ambiguity {
  double weight = 0;     ///< that may change hands
  double most_left = 1;  ///< largest transmittance that ambiguous alphas allow
  double drift = 0;      ///< relative uncertainty of the transmittance by ambiguous alphas
};

/// What a pixel keeps from layer to layer, as numbers of type `Kept`.
template <class Kept>
struct PixelState {
  std::array<Kept, 3> colour{};
  Kept transmittance = 1, depth = 0;
  double weight = 0;  ///< sum of weights, or what the kept transmittance makes of it

  void add(double alpha, const SplatNumbers& splat) {
    const double part = alpha * double(transmittance);
    for (std::size_t c = 0; c < 3; ++c)
      colour[c] = Kept(double(colour[c]) + part * splat.colour[Eigen::Index(c)]);
    depth = Kept(double(depth) + part * splat.depth);
    transmittance = Kept(double(transmittance) - part);
    weight = std::is_same_v<Kept, float> ? 1 - double(transmittance) : weight + part;
  }
  double mean_depth() const { return weight > 0 ? double(depth) / weight : 0; }
};

/// A pixel as it is and in every trial. All take the decisions of the first.
///
/// Trials round to float, because sums of roundings cannot be estimated: near a power of 2 those of equal
/// layers lean to one side, elsewhere they do not.
struct VariedPixel {
  PixelState<double> exact;
  std::array<PixelState<float>, trials> moved;
  std::array<Ambiguity, exponent_representations> representations;
  std::uint32_t layers = 0;
  bool stopped = false;
  float occluder = std::numeric_limits<float>::infinity();
};

/// Moves in the trials up to this many times as large are allowed for at every threshold.
constexpr double threshold_moves = 10;

/// Decisions about one splat at one pixel.
struct PixelDecision {
  std::array<double, trials + 1> alphas;
  bool kept = false;
  std::array<double, exponent_representations>
      ambiguous{};  ///< how far alpha may be from the first of `alphas`, kept or not
};

/// How far a renderer with this representation may be from `alpha`, 0 where it is not kept, at a pixel whose
/// exponent is `exponent` and may move by `tolerance` at the threshold.
double ambiguous_alpha(ExponentRepresentation representation, const VariedSplat& splat, double x, double y,
                       double exponent, double alpha, double tolerance, const Conventions& k) {
  const SplatNumbers& numbers = splat.numbers[0];
  if (!may_be_visited(representation, numbers, int(x), int(y), k)) return 0;
  const double error = exponent_error(representation, numbers, x, y),
               log2_min = std::log2(double(k.alpha_min));
  if (exponent + tolerance + error < log2_min) return 0;
  // `HalfSplit` skips a pixel where rounding makes s negative.
  const bool valid =
      representation != ExponentRepresentation::half_split || numbers.log2_opacity - exponent > error;
  const bool surely_kept = splat.drawn && valid && exponent - tolerance - error > log2_min;
  if (surely_kept && error == 0) return 0;
  const auto alpha_at = [&](double at) {
    return std::min(double(k.alpha_max), std::exp2(std::min(numbers.log2_opacity, at)));
  };
  if (surely_kept) return std::max(alpha_at(exponent + error) - alpha, alpha - alpha_at(exponent - error));
  // The trials blend no splat that the reference skips: what moves its alpha is part of what may change.
  return std::max(alpha_at(exponent + tolerance + error) - alpha, alpha);
}

/// Drops the splat, or makes it ambiguous, where its footprint does so at this pixel.
void cut(PixelDecision& decision, FootprintCut::At at) {
  using At = FootprintCut::At;
  if (at == At::kept) return;
  const double alpha = decision.kept ? decision.alphas[0] : 0;
  for (double& ambiguous : decision.ambiguous) ambiguous = at == At::dropped ? 0 : std::max(ambiguous, alpha);
  if (at != At::ambiguously_kept) decision.kept = false;
}

/// Where the ellipse of three standard deviations has a point.
FootprintCut::At at_ellipse(const VariedSplat& splat, double x, double y) {
  const double squared = 2 * splat.numbers[0].sigma(x, y);
  double spread = 0;
  for (const SplatNumbers& n : splat.numbers)
    spread = std::max(spread, std::abs(2 * n.sigma(x, y) - squared));
  const double off = threshold_moves * spread + std::ldexp(three_sigmas_squared, -22);
  if (squared <= three_sigmas_squared)
    return squared + off <= three_sigmas_squared ? FootprintCut::At::kept
                                                 : FootprintCut::At::ambiguously_kept;
  return squared - off > three_sigmas_squared ? FootprintCut::At::dropped
                                              : FootprintCut::At::ambiguously_dropped;
}

/// Finds alphas of `splat` at a point, whether it is kept there, and how sure that is.
PixelDecision decide(const VariedSplat& splat, double x, double y, const Conventions& k) {
  PixelDecision out;
  const double log2_e = 1.4426950408889634, log2_min = std::log2(double(k.alpha_min));
  double first = 0, spread = 0;
  for (std::size_t t = 0; t <= trials; ++t) {
    const SplatNumbers& n = splat.numbers[t];
    out.alphas[t] = n.log2_opacity - n.sigma(x, y) * log2_e;
    if (t == 0) first = out.alphas[0];
    spread = std::max(spread, std::abs(out.alphas[t] - first));
  }
  out.kept = splat.drawn && first >= log2_min && splat.splat.opacity >= double(k.alpha_min);
  const double tolerance = threshold_moves * spread + std::ldexp(4 + std::abs(log2_min), -22);
  if (out.kept) {
    const double log2_max = std::log2(double(k.alpha_max)),
                 rounding = std::ldexp(4 + std::abs(log2_min), -22);
    // The cut at alpha_max may hide the move of a trial where rounding may take alpha below it. Then the
    // trial moves as far down: light behind a nearly opaque splat shows it.
    for (std::size_t t = 1; t <= trials && first - spread - rounding < log2_max; ++t)
      if (std::max(first, out.alphas[t]) > log2_max)
        out.alphas[t] = std::min(first, log2_max) - std::abs(out.alphas[t] - first);
    for (double& alpha : out.alphas) alpha = std::min(double(k.alpha_max), std::exp2(alpha));
  }
  for (std::size_t representation = 0; representation < exponent_representations; ++representation)
    out.ambiguous[representation] = ambiguous_alpha(ExponentRepresentation(representation), splat, x, y,
                                                    first, out.kept ? out.alphas[0] : 0, tolerance, k);
  cut(out, k.footprint == Conventions::Footprint::three_sigma_ellipse ? at_ellipse(splat, x, y)
                                                                      : splat.cut.at(int(x), int(y)));
  return out;
}

/// Whether the splat, of transmittance `next` behind it, ends the pixel; adds what that leaves open.
bool ends(VariedPixel& pixel, const VariedSplat& splat, const PixelDecision& decision, double next,
          const Conventions& k) {
  const double stop = k.stop, before = pixel.exact.transmittance;
  double spread = 0;
  for (std::size_t t = 0; t < trials; ++t)
    spread = std::max(spread,
                      std::abs(double(pixel.moved[t].transmittance) * (1 - decision.alphas[t + 1]) - next));
  // Transmittance is rounded once a layer, and a splat that is nearly opaque leaves little of much.
  const double rounding = std::ldexp((double(pixel.layers) + 2) * next, -23) + std::ldexp(before, -21);
  const bool order_of_occluder =
      (splat.least_order >= pixel.occluder) != (splat.largest_order >= pixel.occluder);
  for (Ambiguity& representation : pixel.representations) {
    const double tolerance = threshold_moves * spread + rounding + representation.drift * next;
    if ((stop > 0 && std::abs(next - stop) <= tolerance) || order_of_occluder)
      representation.weight += representation.most_left;
  }
  return (k.stop_at_equal ? next <= stop : next < stop) || float(splat.splat.depth) >= pixel.occluder;
}

/// Blends the splat into the pixel, as it is and in every trial.
void blend_varied(VariedPixel& pixel, const VariedSplat& splat, const PixelDecision& decision,
                  const Conventions& k) {
  const double alpha = decision.kept ? decision.alphas[0] : 0;
  for (std::size_t f = 0; f < exponent_representations; ++f) {
    Ambiguity& representation = pixel.representations[f];
    representation.weight += representation.most_left * decision.ambiguous[f];
    representation.drift += decision.ambiguous[f] / std::max(1 - alpha, 1e-6);
  }
  if (!decision.kept) return;
  if (ends(pixel, splat, decision, pixel.exact.transmittance * (1 - alpha), k)) {
    pixel.stopped = true;
    return;
  }
  pixel.exact.add(decision.alphas[0], splat.numbers[0]);
  for (std::size_t t = 0; t < trials; ++t) pixel.moved[t].add(decision.alphas[t + 1], splat.numbers[t + 1]);
  for (std::size_t f = 0; f < exponent_representations; ++f) {
    Ambiguity& representation = pixel.representations[f];
    if (splat.order_is_ambiguous) representation.weight += representation.most_left * alpha;
    representation.most_left = std::min(1.0, representation.most_left * (1 - alpha + decision.ambiguous[f]));
  }
  ++pixel.layers;
}

/// Offers `splat` to the pixels of image row `y`.
void blend_row_varied(VariedPixel* pixels, int y, const VariedSplat& splat, const Conventions& k) {
  for (int x = splat.splat.x_begin; x < splat.splat.x_end; ++x)
    if (!pixels[x].stopped) blend_varied(pixels[x], splat, decide(splat, x + 0.5, y + 0.5, k), k);
}

/// Writes image row `y`, blended in `out.colours` over `below`, with the largest moves and the ambiguous
/// weights of its pixels.
void write_row_varied(ConditionedFrame& out, int y, const VariedPixel* pixels, dvec3 below) {
  const std::size_t width = std::size_t(out.frame.width);
  for (std::size_t x = 0; x < width; ++x) {
    const std::size_t i = std::size_t(y) * width + x;
    const VariedPixel& pixel = pixels[x];
    const auto value_of = [&](const auto& state, std::size_t c) {
      return shown(double(state.colour[c]) + double(state.transmittance) * below[int(c)], out.colours);
    };
    for (std::size_t c = 0; c < 3; ++c) out.frame.colour[3 * i + c] = value_of(pixel.exact, c);
    out.frame.alpha[i] = 1 - pixel.exact.transmittance;
    out.frame.depth[i] = pixel.exact.mean_depth();
    for (const auto& state : pixel.moved) {
      const auto note = [](double& move, double value, double exact) {
        move = std::max(move, std::abs(value - exact));
      };
      for (std::size_t c = 0; c < 3; ++c)
        note(out.colour_move[3 * i + c], value_of(state, c), out.frame.colour[3 * i + c]);
      note(out.alpha_move[i], 1 - double(state.transmittance), out.frame.alpha[i]);
      note(out.depth_move[i], state.mean_depth(), out.frame.depth[i]);
    }
    for (std::size_t representation = 0; representation < exponent_representations; ++representation)
      out.ambiguous[representation][i] = pixel.representations[representation].weight;
  }
}

}  // namespace
}  // namespace reference

ConditionedFrame render_conditioned(Span<const ReferenceScene> scenes, const Camera& camera,
                                    const Conventions& given, dvec3 background, const StressTrials& moves,
                                    int threads, Span<const float> occluder) {
  using namespace reference;
  ConditionedFrame out;
  check_reference_arguments(scenes, camera, background, occluder);
  const Conventions conventions = of_frame(given, scenes, occluder.size != 0);
  if (conventions.depth_at != Conventions::DepthAt::centre)
    throw InvalidArgument("render_conditioned: expected depths of centres");
  validate(conventions);
  threads = thread_count(threads);
  prepare(out.frame, camera);
  out.colours = *conventions.colours;
  const dvec3 below = blended(background, out.colours);
  out.colour_move.resize(out.frame.colour.size());
  out.alpha_move.resize(out.frame.alpha.size()), out.depth_move.resize(out.frame.alpha.size());
  for (std::vector<double>& ambiguous : out.ambiguous) ambiguous.resize(out.frame.alpha.size());

  const std::vector<VariedSplat> splats = project_all_varied(views_of(scenes, camera, conventions), moves);
  for_each_index(std::size_t(camera.height), threads, [&](std::size_t row) {
    const int y = int(row);
    std::vector<VariedPixel> pixels(std::size_t(camera.width));
    for (std::size_t x = 0; occluder.size > 0 && x < pixels.size(); ++x)
      pixels[x].occluder = occluder[row * pixels.size() + x];
    for (const VariedSplat& splat : splats)
      if (y >= splat.splat.y_begin && y < splat.splat.y_end)
        blend_row_varied(pixels.data(), y, splat, conventions);
    write_row_varied(out, y, pixels.data(), below);
  });

  double lowest = std::min({0.0, below.x, below.y, below.z});
  double highest = std::max({0.0, below.x, below.y, below.z});
  for (const VariedSplat& splat : splats) {
    highest = std::max(highest, splat.splat.colour.maxCoeff());
    out.depth_span = std::max(out.depth_span, splat.splat.depth);
  }
  out.colour_span = highest - lowest;
  for (const double value : out.frame.colour) out.peak = std::max(out.peak, std::abs(value));
  return out;
}

}  // namespace swiftgs
