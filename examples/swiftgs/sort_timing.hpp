// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/sort/calibration.hpp>

#include "progress.hpp"
#include "views.hpp"

namespace swiftgs::cli {

/// Mean of `values`, at least one, and their standard deviation, 0 for one alone.
double mean_of(const std::vector<double>& values);
double spread_of(const std::vector<double>& values);

/// Sort times with one strategy. @units{milliseconds}
struct StrategyTimes {
  std::vector<std::string> views;
  std::vector<double> ms;
};

/// What the choice of a strategy rests on. The k-th times of both are of views with about as many instances.
struct SortTimes {
  StrategyTimes standard, early;

  double standard_ms() const { return mean_of(standard.ms); }
  double early_ms() const { return mean_of(early.ms); }
};

/// How much longer than with the better strategy a sort is expected to take, as a part of it, when the one
/// with the lower mean is chosen: the means differ by what the pairs do, and their difference is uncertain by
/// the standard error of that, taken for normal. Nothing where there are fewer than two pairs.
std::optional<double> expected_regret(const SortTimes& times);

/// A fifth of `views`, rounded up to whole pairs and at least one pair, at random by `seed`: numbers below
/// `views`. One view alone is chosen alone.
std::vector<std::size_t> random_fifth(std::size_t views, std::uint64_t seed);

/// The paper's procedure (SwiftGS, section 4.2): sorts one half of `chosen` with `standard`, the other with
/// `early`; one view alone with both. Neighbours in the number of instances go to different halves, at random
/// by `seed`, so that the halves differ little in what there is to sort.
SortTimes time_sorts(AnyRenderer& standard, AnyRenderer& early, const std::vector<View>& chosen,
                     const RenderSettings& settings, std::uint64_t seed, Progress& progress);

/// Durations of one renderer's frames, one for each view. @units{milliseconds}
struct FrameTimes {
  std::vector<double> sort, total;
};

/// Times `renderers` on all `views` in turn, each round in a new order: a machine that drifts or is shared is
/// no one's advantage. A turn begins with a frame that is not timed where the one before was of another
/// renderer, whose data are in the caches, or of another view. A view's time is the median of `turns`.
std::vector<FrameTimes> time_in_turn(const std::vector<AnyRenderer*>& renderers,
                                     const std::vector<View>& views, const RenderSettings& settings,
                                     int turns, Progress& progress);

}  // namespace swiftgs::cli
