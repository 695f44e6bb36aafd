// SPDX-License-Identifier: Apache-2.0
#include "sort_timing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

namespace swiftgs::cli {
namespace {

/// Of a chosen view: few views decide, so each is timed well.
constexpr int turns_of_chosen = 7;

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A number below `limit`. The same on every platform, which `std::uniform_int_distribution` is not.
std::size_t below(std::size_t limit, std::mt19937_64& random) { return std::size_t(random() % limit); }

/// Pairs of numbers of views: of two neighbours in the number of instances one comes first, at random.
std::vector<std::array<std::size_t, 2>> pairs_of(const std::vector<std::size_t>& instances,
                                                 std::mt19937_64& random) {
  std::vector<std::size_t> order(instances.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return instances[a] < instances[b]; });
  std::vector<std::array<std::size_t, 2>> pairs;
  if (order.size() == 1) pairs.push_back({0, 0});
  for (std::size_t i = 0; i + 1 < order.size(); i += 2) {
    pairs.push_back({order[i], order[i + 1]});
    if (below(2, random)) std::swap(pairs.back()[0], pairs.back()[1]);
  }
  return pairs;
}

}  // namespace

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

double spread_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return values.size() < 2 ? 0 : std::sqrt(squares / double(values.size() - 1));
}

std::optional<double> expected_regret(const SortTimes& times) {
  const std::size_t pairs = times.standard.ms.size();
  if (pairs < 2) return std::nullopt;
  std::vector<double> differences;
  for (std::size_t i = 0; i < pairs; ++i) differences.push_back(times.standard.ms[i] - times.early.ms[i]);
  const double error = spread_of(differences) / std::sqrt(double(pairs));
  if (error == 0) return 0.0;
  // The mean of max(0, -d) for a normal d around the difference.
  const double z = std::abs(mean_of(differences)) / error;
  const double density = std::exp(-0.5 * z * z) / std::sqrt(2 * std::acos(-1.0));
  const double tail = 0.5 * std::erfc(z / std::sqrt(2.0));
  return std::max(0.0, error * (density - z * tail)) / std::min(times.standard_ms(), times.early_ms());
}

std::vector<std::size_t> random_fifth(std::size_t views, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::size_t> numbers(views);
  std::iota(numbers.begin(), numbers.end(), std::size_t(0));
  const std::size_t count = views < 2 ? views : 2 * ((views + 9) / 10);
  for (std::size_t i = 0; i < count; ++i) std::swap(numbers[i], numbers[i + below(views - i, random)]);
  numbers.resize(count);
  return numbers;
}

SortTimes time_sorts(AnyRenderer& standard, AnyRenderer& early, const std::vector<View>& chosen,
                     const RenderSettings& settings, std::uint64_t seed, Progress& progress) {
  std::vector<std::size_t> instances;
  for (const View& view : chosen) {
    progress.start("counting " + view.name);
    standard.render_resident(view.camera, settings), early.render_resident(view.camera, settings);
    instances.push_back(standard.statistics().instances);
    progress.step();
  }
  SortTimes times;
  const auto time = [&](AnyRenderer& renderer, const View& view, StrategyTimes& into) {
    into.views.push_back(view.name);
    into.ms.push_back(
        time_in_turn({&renderer}, {view}, settings, turns_of_chosen, progress).front().sort.front());
  };
  std::mt19937_64 random(seed);
  for (const auto& [first, second] : pairs_of(instances, random)) {
    time(standard, chosen[first], times.standard);
    time(early, chosen[second], times.early);
  }
  return times;
}

// `measure` of bench/measure.hpp takes turns too, until one view's median is precise, however long that
// takes. Here a mean over views decides, which differ by more than the median of a few frames: each has the
// same few.
std::vector<FrameTimes> time_in_turn(const std::vector<AnyRenderer*>& renderers,
                                     const std::vector<View>& views, const RenderSettings& settings,
                                     int turns, Progress& progress) {
  std::vector<FrameTimes> times(renderers.size());
  std::vector<std::size_t> order(renderers.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::mt19937_64 random;
  for (const View& view : views) {
    progress.start("timing " + view.name);
    std::vector<FrameTimes> of_turns(renderers.size());
    const AnyRenderer* last = nullptr;
    for (std::size_t turn = 0; turn < std::size_t(turns) * renderers.size(); ++turn) {
      const std::size_t place = turn % renderers.size();
      std::swap(order[place], order[place + below(renderers.size() - place, random)]);
      const std::size_t i = order[place];
      if (last != renderers[i]) renderers[i]->render_resident(view.camera, settings);
      last = renderers[i];
      renderers[i]->render_resident(view.camera, timed(settings));
      const StageTimes ms = renderers[i]->times();
      of_turns[i].sort.push_back(ms.sort), of_turns[i].total.push_back(ms.total);
    }
    for (std::size_t i = 0; i < renderers.size(); ++i) {
      times[i].sort.push_back(median_of(of_turns[i].sort));
      times[i].total.push_back(median_of(of_turns[i].total));
    }
    progress.step();
  }
  return times;
}

}  // namespace swiftgs::cli
