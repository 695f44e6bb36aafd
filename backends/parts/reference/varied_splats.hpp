// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/scene.hpp>

#include "projection.hpp"
#include "variation.hpp"

namespace swiftgs::reference {

/// A splat with its numbers in every trial.
struct VariedSplat {
  Splat splat;
  std::vector<SplatNumbers> numbers;  ///< as it is, then `trials` times
  FootprintCut cut{};
  bool drawn = false;                        ///< its depth lies between the planes
  bool order_is_ambiguous = false;           ///< what orders it may round to that of a neighbour
  float least_order = 0, largest_order = 0;  ///< floats that this may round to: of its depth, or distance
};

/// How far double arithmetic may move the depth of Gaussian `i`, or its distance: no more than its position
/// in camera space.
inline double depth_error(std::size_t i, const View& view, bool by_distance) {
  const vec3& m = view.placed.scene.means[i];
  const dvec3 &scene_at = view.placed.world_from_scene.translation, &camera_at = view.camera.translation;
  double sum = 0;
  for (int row = by_distance ? 0 : 2; row < 3; ++row) {
    sum += std::abs(camera_at[row]);
    for (int k = 0; k < 3; ++k) {
      const double in_scene = std::abs(double(m[k])) + std::abs(view.centre[k]);
      sum += view.scale * std::abs(view.rotation(row, k)) * in_scene;
      sum += std::abs(view.camera.rotation[k][row]) * std::abs(scene_at[k]);
    }
  }
  return std::ldexp(sum, -49);
}

/// Projects Gaussian `i` of the view's scene, and of the trials `moved`. Nothing where no rounding could draw
/// it.
inline std::optional<VariedSplat> project_varied(const std::vector<Scene>& moved, std::size_t i,
                                                 const View& view, Columns part, const StressTrials& moves) {
  const Scene& scene = view.placed.scene;
  if (!is_shown(view.placed.clip, scene.means[i])) return {};
  const Eigen::Vector3d p = camera_space_mean(scene, i, view);
  const Conventions& k = view.conventions;
  const double slack = depth_error(i, view, view.lens.by_distance());
  const double depth = view.lens.depth(p);
  const float low = float(depth - slack), high = float(depth + slack);
  const auto between_planes = [&](float z) { return is_between_planes(z, k); };
  if (!between_planes(float(depth)) && !between_planes(low) && !between_planes(high)) return {};
  std::optional<Splat> splat = project_unculled(scene, i, p, view, part);
  if (!splat || !shade(*splat, scene, i, view)) return {};
  VariedSplat out{.splat = *splat, .numbers = {}};
  out.drawn = between_planes(float(splat->depth));
  const double order_slack = *k.order == SplatOrder::distance ? depth_error(i, view, true) : slack;
  out.least_order = float(splat->order - order_slack), out.largest_order = float(splat->order + order_slack);

  Nudges nudges(moves.seed ^ (splat->index * 0x2545f4914f6cdd1du));
  out.numbers.emplace_back(*splat);
  for (const Scene& trial : moved) {
    // A trial in which the splat cannot be drawn at all tells nothing of how far it moves.
    std::optional<Splat> there = project_unculled(trial, i, camera_space_mean(trial, i, view), view, part);
    if (!there || !shade(*there, trial, i, view)) there = splat;
    out.numbers.emplace_back(*there);
    if (!moves.scene_only) nudge_stored(out.numbers.back(), nudges);
  }
  if (k.footprint == Conventions::Footprint::three_sigma_square) out.cut = FootprintCut(*splat, out.numbers);
  return out;
}

/// Widens what `splat` may reach by far more than rounding can, and by the pixels that share a row of a tile.
inline void bound_varied(VariedSplat& splat, const View& view, Columns part) {
  Splat& s = splat.splat;
  const double cutoff = std::max(s.cutoff, 0.0);
  Splat wide = s;
  wide.cutoff = cutoff * 1.01 + 0.01;
  bound_by_alpha(wide, view, part);
  s.y_begin = std::max(0, wide.y_begin - 1), s.y_end = std::min(view.camera.height, wide.y_end + 1);
  s.x_begin = std::max(part.begin, wide.x_begin - 16), s.x_end = std::min(part.end, wide.x_end + 16);
}

/// Finds splats whose order rounding may turn. Depths or distances of one float each are in order, or equal
/// and ordered by index.
inline void mark_ambiguous_orders(std::vector<VariedSplat>& splats) {
  std::vector<VariedSplat*> by_least;
  for (VariedSplat& splat : splats) by_least.push_back(&splat);
  std::sort(by_least.begin(), by_least.end(),
            [](const VariedSplat* a, const VariedSplat* b) { return a->least_order < b->least_order; });
  const auto is_one_float = [](const VariedSplat& s) { return s.least_order == s.largest_order; };
  for (std::size_t i = 0; i < by_least.size(); ++i) {
    VariedSplat& first = *by_least[i];
    for (std::size_t j = i + 1; j < by_least.size(); ++j) {
      VariedSplat& other = *by_least[j];
      if (other.least_order > first.largest_order) break;
      if (other.splat.index == first.splat.index) continue;  // copies in a panorama
      if (!is_one_float(first) || !is_one_float(other))
        first.order_is_ambiguous = other.order_is_ambiguous = true;
    }
  }
}

/// Appends the splats of a placed scene.
inline void project_varied(const View& view, const StressTrials& moves, std::vector<VariedSplat>& splats) {
  const Scene& scene = view.placed.scene;
  std::vector<Scene> moved;
  for (std::size_t t = 0; t < trials; ++t)
    moved.push_back(nudged(scene, moves.seed + 977 * (t + 1) + view.first));
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (const Columns part : view.parts) {
      std::optional<VariedSplat> splat = project_varied(moved, i, view, part, moves);
      if (!splat || !(splat->splat.opacity >= 0.99 * double(view.conventions.alpha_min))) continue;
      bound_varied(*splat, view, part);
      if (splat->splat.x_begin < splat->splat.x_end && splat->splat.y_begin < splat->splat.y_end)
        splats.push_back(std::move(*splat));
    }
}

inline std::vector<VariedSplat> project_all_varied(const std::vector<View>& views,
                                                   const StressTrials& moves) {
  std::vector<VariedSplat> splats;
  for (const View& view : views) project_varied(view, moves, splats);
  std::stable_sort(splats.begin(), splats.end(), [](const VariedSplat& a, const VariedSplat& b) {
    return float(a.splat.order) < float(b.splat.order);
  });
  mark_ambiguous_orders(splats);
  return splats;
}

}  // namespace swiftgs::reference
