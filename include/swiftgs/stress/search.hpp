// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/edit/select.hpp>
#include <swiftgs/stress/families.hpp>
#include <swiftgs/stress/judge.hpp>
#include <swiftgs/stress/mutation.hpp>

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
  double excess = 0;  ///< infinity where `error` says what is wrong
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

/// Climbs towards the largest excess of several renderers at once. What it tries follows from the seed and
/// from the frames: the same renderers find the same.
///
/// A try draws a small frame, either one of a family or a neighbour of an earlier one. Earlier frames are
/// kept in an archive, the worst of each niche: a renderer, colours or depth, a family, and how long the
/// longest axis is and how nearly it points at the camera. So a search climbs many hills.
class StressSearch {
 public:
  static constexpr ImageSize size{16, 16};
  static constexpr std::size_t most_gaussians = 8;
  /// Weight of a pixel that may change hands. A frame that leaves more open is no find.
  static constexpr double most_loose = 0.1;

  /// What an excess is of.
  enum Plane : std::size_t { colour, depth };
  static constexpr std::size_t planes = 2;

  StressSearch(std::vector<StressSubject> subjects, std::vector<StressFamily> families, std::uint64_t seed)
      : subjects_(std::move(subjects)),
        families_(std::move(families)),
        random_(SplitMix64::scrambled(seed)),
        hills_(subjects_.size() * planes * families_.size()) {
    for (std::size_t i = 0; i < subjects_.size(); ++i) {
      twins_.push_back(0);
      while (without_sort(subjects_[twins_[i]].name) != without_sort(subjects_[i].name)) ++twins_[i];
    }
  }

  /// Draws one frame with every renderer.
  void try_one() {
    const std::size_t family = tries_ % families_.size();
    const std::size_t objective = tries_ / families_.size() % (subjects_.size() * planes);
    ++tries_;
    const Niches& known = hills_[objective * families_.size() + family].niches;
    const bool fresh = known.empty() || random_.below(8) == 0;
    const StressCase drawn = fresh ? start(families_[family]) : stress::mutated(random_, parent(known));
    // Some frames of families lie a little beyond a limit.
    if (stress::is_valid(drawn)) judge_all(drawn, family);
  }
  void run(std::uint64_t tries) {
    for (std::uint64_t i = 0; i < tries; ++i) try_one();
  }

  std::uint64_t tries() const { return tries_; }
  const std::vector<StressSubject>& subjects() const { return subjects_; }
  const std::vector<StressFamily>& families() const { return families_; }

  const StressFind& worst(std::size_t subject, Plane plane, std::size_t family) const {
    return hills_[(subject * planes + plane) * families_.size() + family].worst;
  }

 private:
  using Niche = std::array<int, 2>;
  struct Known {
    double excess = 0;
    StressCase drawn;
  };
  using Niches = std::map<Niche, Known>;
  struct Hill {
    Niches niches;
    StressFind worst;
  };

  StressCase start(const StressFamily& family) {
    const double severity = family.severities[std::size_t(random_.below(int(family.severities.size())))];
    StressCase made = family.make(severity, std::uint64_t(random_.below(1 << 30)), size);
    const std::size_t count = 1 + std::size_t(random_.below(int(most_gaussians)));
    if (made.scene.size() <= count) return made;
    std::vector<std::uint32_t> kept;
    for (std::size_t i = 0; i < count; ++i)
      kept.push_back(std::uint32_t(random_.below(int(made.scene.size()))));
    made.scene = subset(made.scene, kept);
    return made;
  }

  /// The worse of two.
  const StressCase& parent(const Niches& known) {
    const auto any = [&] { return std::next(known.begin(), random_.below(int(known.size()))); };
    const auto first = any(), second = any();
    return (first->second.excess >= second->second.excess ? first : second)->second.drawn;
  }

  /// Of the Gaussian that is longest for its depth.
  static Niche niche_of(const StressCase& drawn) {
    Niche niche{-3, 0};
    const auto decade = [](double value, int low, int high) {
      return int(std::clamp(std::floor(std::log10(value)), double(low), double(high)));
    };
    for (std::size_t i = 0; i < drawn.scene.size(); ++i) {
      const stress::LongestAxis longest(drawn, i);
      niche =
          std::max(niche, Niche{decade(longest.scale / longest.depth, -2, 7), decade(longest.sine(), -8, 0)});
    }
    return niche;
  }

  void judge_all(const StressCase& drawn, std::size_t family) {
    References references(drawn);
    std::vector<Frame> frames(subjects_.size());
    for (std::size_t i = 0; i < subjects_.size(); ++i) {
      const auto hill = [&](Plane plane) -> Hill& {
        return hills_[(i * planes + plane) * families_.size() + family];
      };
      const auto fail = [&](const std::string& error) {
        StressFind& worst = hill(colour).worst;
        if (worst.error.empty()) worst = {std::numeric_limits<double>::infinity(), drawn, error};
      };
      try {
        frames[i] = subjects_[i].draw(drawn);
      } catch (const std::exception& error) {
        fail(error.what());
        continue;
      }
      const std::size_t twin = twins_[i];
      if (!is_finite(frames[i]))
        fail("a value is not finite");
      else if (twin < i && !frames[twin].colour.empty() && !is_same(frames[i], frames[twin]))
        fail("differs from " + subjects_[twin].name);
      else
        for (const Plane plane : {colour, depth})
          climb(hill(plane), references, frames[i], exponent_form_named(subjects_[i].name), plane);
    }
  }

  /// References of one frame with other trials each, drawn when they are first asked for.
  class References {
   public:
    static constexpr std::size_t count = 3;
    explicit References(const StressCase& drawn) : drawn_(drawn) {}

    const StressCase& drawn() const { return drawn_; }
    const ConditionedFrame& operator[](std::size_t i) {
      if (!frames_[i])
        frames_[i] = render_conditioned(drawn_.scene, drawn_.camera, drawn_.conventions,
                                        dvec3(drawn_.background), i + 1, 1);
      return *frames_[i];
    }

   private:
    const StressCase& drawn_;
    std::array<std::optional<ConditionedFrame>, count> frames_;
  };

  /// Keeps the frame if it is the worst of its niche. The least excess of several references counts: a climb
  /// would else lead to where the trials of one happen to move little.
  static void climb(Hill& hill, References& references, const Frame& frame, ExponentForm form, Plane plane) {
    const StressCase& drawn = references.drawn();
    const Niche niche = niche_of(drawn);
    const auto known = hill.niches.find(niche);
    const double least = known == hill.niches.end() ? 0 : known->second.excess;
    double excess = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < References::count && excess > least; ++i) {
      const StressVerdict verdict = judge(references[i], frame, form);
      if (verdict.judged < 1 || verdict.loosest > most_loose) return;
      excess = std::min(excess, plane == colour ? verdict.excess : verdict.depth_excess);
    }
    if (!(excess > least)) return;
    hill.niches[niche] = {excess, drawn};
    if (excess > hill.worst.excess) hill.worst = {excess, drawn, ""};
  }

  static bool is_finite(const Frame& frame) {
    for (const std::vector<float>* values : {&frame.colour, &frame.alpha, &frame.depth})
      if (!std::all_of(values->begin(), values->end(), [](float v) { return std::isfinite(v); }))
        return false;
    return true;
  }
  static bool is_same(const Frame& a, const Frame& b) {
    return a.colour == b.colour && a.alpha == b.alpha && a.depth == b.depth;
  }

  /// A renderer's name without its sort, which changes no bit.
  static std::string without_sort(const std::string& name) {
    const std::size_t first = std::min(name.find('/'), name.size());
    return name.substr(0, first) + name.substr(std::min(name.find('/', first + 1), name.size()));
  }

  std::vector<StressSubject> subjects_;
  std::vector<std::size_t> twins_;  ///< the first subject that differs from each in the sort alone
  std::vector<StressFamily> families_;
  stress::Random random_;
  std::vector<Hill> hills_;
  std::uint64_t tries_ = 0;
};

}  // namespace swiftgs
