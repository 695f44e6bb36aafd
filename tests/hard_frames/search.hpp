// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/edit/select.hpp>
#include <swiftgs/stress.hpp>

#include "hard_frames/climb.hpp"
#include "hard_frames/families.hpp"
#include "hard_frames/mutation.hpp"

/// @file
/// A search for frames that a renderer draws worse than float can.

namespace swiftgs {

/// A renderer that a search draws with.
struct StressSubject {
  std::string name;                              ///< BACKEND/SORT/RASTER/BOUNDS
  std::function<Frame(const StressCase&)> draw;  ///< with alpha and depth
};

/// The worst frame of one renderer that a search found from one family.
struct StressFind {
  double normalised_error = 0;  ///< infinity where there is an `error`
  StressCase drawn;
  std::string error;  ///< what the renderer threw, or what is wrong with its frame; or empty
};

/// Families that a search starts from: all of the sweep, and lone Gaussians.
inline const std::vector<StressFamily>& search_families() {
  static const std::vector<StressFamily> all = [] {
    std::vector<StressFamily> families = stress_families();
    for (const StressFamily& family : stress::lone_families()) families.push_back(family);
    return families;
  }();
  return all;
}

namespace stress {

/// References of one frame that differ in their trials, each drawn when it is first asked for.
class References {
 public:
  static constexpr std::size_t count = 8;
  References(const StressCase& drawn, bool scene_only) : drawn_(drawn), scene_only_(scene_only) {}

  const ConditionedFrame& operator[](std::size_t i) {
    if (!frames_[i]) frames_[i] = render_conditioned(drawn_, {i + 1, scene_only_}, 1);
    return *frames_[i];
  }

 private:
  const StressCase& drawn_;
  bool scene_only_;
  std::array<std::optional<ConditionedFrame>, count> frames_;
};

/// What a frame shows of hardness: decades of the longest axis over its depth, of the sine of the angle at
/// which it points at the camera, and of focal lengths over the image's width. Of several Gaussians the one
/// that is longest for its depth counts.
using Niche = std::array<int, 3>;

inline Niche niche_of(const StressCase& drawn) {
  const auto decade = [](double value, int low, int high) {
    if (value < 0) return low - 1;  // behind the camera
    return std::isfinite(value) ? int(std::clamp(std::floor(std::log10(value)), double(low), double(high)))
                                : high;
  };
  const int lens = decade(drawn.camera.fx / drawn.camera.width, -3, 3);
  Niche niche{-3, 0, lens};
  for (std::size_t i = 0; i < drawn.scene.size(); ++i) {
    const LongestAxis longest(drawn, i);
    niche =
        std::max(niche, {decade(longest.scale / longest.depth, -2, 7), decade(longest.sine(), -8, 0), lens});
  }
  return niche;
}

/// A renderer's name without its sort, which changes no bit.
inline std::string without_sort(const std::string& name) {
  const std::size_t first = std::min(name.find('/'), name.size());
  return name.substr(0, first) + name.substr(std::min(name.find('/', first + 1), name.size()));
}

}  // namespace stress

/// Climbs towards the largest normalised error of several renderers at once. What it tries follows from the
/// seed and from the frames: the same renderers find the same.
///
/// A try draws a small frame, either one of a family or a neighbour of an earlier one. Earlier frames are
/// kept for each renderer, of colours and of depth apart: the worst of each `stress::Niche`. So a search
/// climbs many hills.
class StressSearch {
 public:
  static constexpr ImageSize one_tile{16, 16}, several_tiles{40, 24};
  static constexpr int most_gaussians = 4;
  /// Weight of a pixel that may change hands. A frame that leaves more open is no find.
  static constexpr double most_ambiguity = 0.1;

  /// What a normalised error is of; colour includes transmittance.
  enum Plane : std::size_t { colour, depth };
  static constexpr std::size_t planes = 2;

  /// `scene_only` as of `StressTrials`.
  StressSearch(std::vector<StressSubject> subjects, std::vector<StressFamily> families, std::uint64_t seed,
               bool scene_only = false)
      : subjects_(std::move(subjects)),
        families_(std::move(families)),
        scene_only_(scene_only),
        random_(SplitMix64::scrambled(seed)),
        climb_(subjects_.size() * planes, true),
        worst_(climb_.objectives() * families_.size()) {
    for (std::size_t i = 0; i < subjects_.size(); ++i) {
      twins_.push_back(0);
      while (stress::without_sort(subjects_[twins_[i]].name) != stress::without_sort(subjects_[i].name))
        ++twins_[i];
    }
  }

  /// Draws one frame with every renderer.
  void try_one() {
    const std::size_t objective = tries_++ % climb_.objectives();
    judge_all(climb_.next(
        random_, objective, climb_.knows(objective) && random_.below(8) == 0,
        [this](stress::Random&) { return start(); },
        [](stress::Random& random, Started& frame) { frame.drawn = stress::mutated(random, frame.drawn); }));
  }
  void run(std::uint64_t tries) {
    for (std::uint64_t i = 0; i < tries; ++i) try_one();
  }

  std::uint64_t tries() const { return tries_; }
  const std::vector<StressSubject>& subjects() const { return subjects_; }
  const std::vector<StressFamily>& families() const { return families_; }

  /// The worst of a subject among frames that began as one of a family.
  const StressFind& worst(std::size_t subject, Plane plane, std::size_t family) const {
    return worst_[index_of(subject, plane, family)];
  }

 private:
  /// A frame, and the family of the one that it began as.
  struct Started {
    StressCase drawn;
    std::size_t family = 0;
  };

  std::size_t index_of(std::size_t subject, Plane plane, std::size_t family) const {
    return (subject * planes + plane) * families_.size() + family;
  }

  /// A frame of some of the Gaussians of a family, mostly of one.
  Started start() {
    const auto number = std::size_t(random_.below(int(families_.size())));
    const StressFamily& family = families_[number];
    const double severity = family.severities[std::size_t(random_.below(int(family.severities.size())))];
    const ImageSize size = random_.below(8) ? one_tile : several_tiles;
    StressCase made = family.make(severity, std::uint64_t(random_.below(1 << 30)), size);
    const int most = 1 + random_.below(most_gaussians), count = 1 + random_.below(most);
    if (made.scene.size() <= std::size_t(count)) return {std::move(made), number};
    std::vector<std::uint32_t> kept;
    for (int i = 0; i < count; ++i) kept.push_back(std::uint32_t(random_.below(int(made.scene.size()))));
    made.scene = subset(made.scene, kept);
    return {std::move(made), number};
  }

  void judge_all(const Started& started) {
    const auto& [drawn, family] = started;
    // Some frames of families, and some neighbours, lie beyond a limit.
    if (!stress::is_valid(drawn)) return;
    stress::References references(drawn, scene_only_);
    std::vector<Frame> frames(subjects_.size());
    for (std::size_t i = 0; i < subjects_.size(); ++i) {
      std::string error;
      try {
        frames[i] = subjects_[i].draw(drawn);
        const Frame& twin = frames[twins_[i]];
        if (!is_finite(frames[i]))
          error = "a value is not finite";
        else if (!twin.colour.empty() && !same_planes(frames[i], twin))
          error = "the frame differs from that of " + subjects_[twins_[i]].name;
      } catch (const std::exception& thrown) {
        error = thrown.what();
      }
      if (error.empty()) {
        climb(i, started, references, frames[i]);
      } else if (StressFind& worst = worst_[index_of(i, colour, family)]; worst.error.empty()) {
        worst = {std::numeric_limits<double>::infinity(), drawn, error};
      }
    }
  }

  /// Keeps the frame where it is the worst of its niche or family. The least normalised error of several
  /// references counts: a climb would else lead to where the trials of one happen to move little.
  void climb(std::size_t subject, const Started& started, stress::References& references,
             const Frame& frame) {
    const auto& [drawn, family] = started;
    const stress::Niche niche = stress::niche_of(drawn);
    const ExponentRepresentation representation = exponent_representation_named(subjects_[subject].name);
    std::array<double, planes> least{},
        normalised_error{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    for (const Plane plane : {colour, depth})
      least[plane] = std::min(std::max(0.0, climb_.value(subject * planes + plane, niche)),
                              worst(subject, plane, family).normalised_error);
    const auto is_worse = [&] {
      return normalised_error[colour] > least[colour] || normalised_error[depth] > least[depth];
    };
    for (std::size_t i = 0; i < stress::References::count && is_worse(); ++i) {
      const StressVerdict verdict = judge(references[i], frame, representation);
      if (verdict.judged < 1 || verdict.ambiguity > most_ambiguity) return;
      normalised_error[colour] = std::min(normalised_error[colour], verdict.normalised_error);
      normalised_error[depth] = std::min(normalised_error[depth], verdict.normalised_depth_error);
    }
    for (const Plane plane : {colour, depth}) {
      climb_.offer(subject * planes + plane, niche, started, normalised_error[plane]);
      StressFind& worst = worst_[index_of(subject, plane, family)];
      if (normalised_error[plane] > worst.normalised_error) worst = {normalised_error[plane], drawn, ""};
    }
  }

  std::vector<StressSubject> subjects_;
  std::vector<std::size_t> twins_;  ///< the first subject that differs from each in the sort alone
  std::vector<StressFamily> families_;
  bool scene_only_;
  stress::Random random_;
  stress::Climb<Started, stress::Niche> climb_;
  std::vector<StressFind> worst_;
  std::uint64_t tries_ = 0;
};

}  // namespace swiftgs
