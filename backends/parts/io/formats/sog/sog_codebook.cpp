// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include <swiftgs/edit/origin.hpp>

#include "sog_pixels.hpp"

namespace swiftgs::io {
namespace {

/// Ascending numbers with running sums, so the mean and the cost of a range take constant time.
class SortedNumbers {
 public:
  explicit SortedNumbers(std::span<const Occurrence> ascending) : numbers_(ascending) { add_up(); }

  std::size_t size() const { return numbers_.size(); }
  double operator[](std::size_t i) const { return numbers_[i].value; }

  double mean(std::size_t begin, std::size_t end) const {
    if (end == begin + 1) return numbers_[begin].value;  // exactly
    return origin_ + (sums_[end].first - sums_[begin].first) / (sums_[end].times - sums_[begin].times);
  }

  /// Sum of squared distances to the mean.
  double cost(std::size_t begin, std::size_t end) const {
    const double times = sums_[end].times - sums_[begin].times;
    const double first = sums_[end].first - sums_[begin].first;
    return std::max(0.0, sums_[end].second - sums_[begin].second - first * first / times);
  }

  double total_times() const { return sums_.back().times - sums_.front().times; }
  double times_before(std::size_t i) const { return sums_[i].times - sums_.front().times; }

  std::size_t first_above(double value) const {
    return std::size_t(std::partition_point(numbers_.begin(), numbers_.end(),
                                            [&](const Occurrence& n) { return n.value <= value; }) -
                       numbers_.begin());
  }

 private:
  struct Sums {
    double times = 0, first = 0, second = 0;
  };

  /// From the middle outwards and relative to it, so that a few huge numbers at an end do not drown the
  /// others.
  void add_up() {
    const std::size_t middle = numbers_.size() / 2;
    origin_ = numbers_[middle].value;
    sums_.resize(numbers_.size() + 1);
    const auto plus = [&](const Sums& sums, const Occurrence& number, double sign) {
      const double x = number.value - origin_, times = sign * number.times;
      return Sums{sums.times + times, sums.first + times * x, sums.second + times * x * x};
    };
    for (std::size_t i = middle; i < numbers_.size(); ++i) sums_[i + 1] = plus(sums_[i], numbers_[i], 1);
    for (std::size_t i = middle; i > 0; --i) sums_[i - 1] = plus(sums_[i], numbers_[i - 1], -1);
  }

  std::span<const Occurrence> numbers_;
  std::vector<Sums> sums_;  ///< up to each number
  double origin_ = 0;
};

/// Where bins begin, the end included: a bin for each number, or thousands. These are narrow where numbers
/// occur often, and where different ones are close together, but none is wide.
std::vector<std::size_t> bins_of(const SortedNumbers& numbers) {
  constexpr std::size_t most = 4096;
  std::vector<std::size_t> begins;
  if (numbers.size() <= most) {
    for (std::size_t i = 0; i <= numbers.size(); ++i) begins.push_back(i);
    return begins;
  }
  const double least = numbers[0], range = numbers[numbers.size() - 1] - least;
  std::size_t last = most;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const double part = (numbers[i] - least) / range + numbers.times_before(i) / numbers.total_times() +
                        double(i) / double(numbers.size());
    const auto bin = std::size_t(part / 3 * most);
    if (bin != last) begins.push_back(i);
    last = bin;
  }
  begins.push_back(numbers.size());
  return begins;
}

/// The cheapest split of bins into `count` runs, by dynamic programming. With more bins the best last run
/// never begins earlier, so each result bounds the searches for smaller and for larger ends.
class Partition {
 public:
  Partition(const SortedNumbers& numbers, const std::vector<std::size_t>& bins)
      : numbers_(numbers), bins_(bins) {}

  /// Where each run begins, in numbers.
  std::vector<std::size_t> runs(std::size_t count) {
    const std::size_t bins = bins_.size() - 1;
    costs_.assign(bins + 1, std::numeric_limits<double>::infinity());
    for (std::size_t end = 1; end <= bins; ++end) costs_[end] = numbers_.cost(0, bins_[end]);
    next_ = costs_;
    std::vector<std::vector<std::uint32_t>> begins(count, std::vector<std::uint32_t>(bins + 1));
    for (std::size_t run = 1; run < count; ++run) {
      add_run(begins[run], run + 1, bins, run, bins - 1);
      std::swap(costs_, next_);
    }
    std::vector<std::size_t> result(count);
    for (std::size_t run = count, end = bins; run-- > 0; end = begins[run][end])
      result[run] = bins_[begins[run][end]];
    return result;
  }

 private:
  /// Finds where the last run begins for all ends in [first, last], which is in [from, to].
  void add_run(std::vector<std::uint32_t>& begins, std::size_t first, std::size_t last, std::size_t from,
               std::size_t to) {
    if (first > last) return;
    const std::size_t end = (first + last) / 2;
    double best = std::numeric_limits<double>::infinity();
    std::size_t begin = from;
    for (std::size_t i = from; i <= std::min(to, end - 1); ++i) {
      const double cost = costs_[i] + numbers_.cost(bins_[i], bins_[end]);
      if (cost < best) best = cost, begin = i;
    }
    next_[end] = best;
    begins[end] = std::uint32_t(begin);
    add_run(begins, first, end - 1, from, begin);
    add_run(begins, end + 1, last, begin, to);
  }

  const SortedNumbers& numbers_;
  const std::vector<std::size_t>& bins_;
  std::vector<double> costs_, next_;
};

/// Moves the bounds of runs off those of the bins: each number to the run with the nearest mean.
std::vector<double> refine(const SortedNumbers& numbers, std::vector<std::size_t> runs) {
  runs.push_back(numbers.size());
  std::vector<double> means(runs.size() - 1);
  const auto set_means = [&] {
    for (std::size_t i = 0; i < means.size(); ++i)
      if (runs[i] < runs[i + 1]) means[i] = numbers.mean(runs[i], runs[i + 1]);
  };
  set_means();
  for (int round = 0; round < 100; ++round) {
    const std::vector<std::size_t> before = runs;
    for (std::size_t i = 1; i < means.size(); ++i)
      runs[i] = std::max(runs[i - 1], numbers.first_above((means[i - 1] + means[i]) / 2));
    if (runs == before) break;
    set_means();
  }
  return means;
}

/// At most `most` values for ascending `numbers`, ascending.
std::vector<double> values_for(std::span<const Occurrence> numbers, std::size_t most) {
  if (numbers.empty() || most == 0) return {};
  const SortedNumbers sorted(numbers);
  const std::vector<std::size_t> bins = bins_of(sorted);
  return refine(sorted, Partition(sorted, bins).runs(std::min(most, bins.size() - 1)));
}

/// Limits of the numbers that do not stray.
swiftgs::detail::Range limits_of(const std::vector<Occurrence>& numbers) {
  constexpr double far = 8;
  std::vector<float> values;
  values.reserve(numbers.size());
  for (const Occurrence& number : numbers) values.push_back(number.value);
  const auto [low, high] = swiftgs::detail::trimmed_range(values, swiftgs::detail::outermost(values.size()));
  return {low - far * (high - low), high + far * (high - low)};
}

/// Sorts, and joins equal numbers.
void merge(std::vector<Occurrence>& numbers) {
  std::sort(numbers.begin(), numbers.end(), [](auto a, auto b) { return a.value < b.value; });
  std::size_t kept = 0;
  for (const Occurrence& number : numbers) {
    if (kept > 0 && numbers[kept - 1].value == number.value)
      numbers[kept - 1].times += number.times;
    else
      numbers[kept++] = number;
  }
  numbers.resize(kept);
}

}  // namespace

Codebook Codebook::of(std::vector<Occurrence> numbers, std::size_t most) {
  Codebook book;
  if (numbers.empty()) return book;
  const swiftgs::detail::Range limits = limits_of(numbers);
  merge(numbers);
  const std::span<const Occurrence> all(numbers);
  const auto first = [&](auto beyond) {
    return std::size_t(std::partition_point(all.begin(), all.end(), beyond) - all.begin());
  };
  const std::size_t low = first([&](const Occurrence& n) { return double(n.value) < limits.low; });
  const std::size_t high = first([&](const Occurrence& n) { return double(n.value) <= limits.high; });
  const std::size_t below = low, bulk = high - low, above = all.size() - high;

  // By squares of errors, a few numbers far beyond would weigh more than all others.
  const std::size_t strays = std::max(most / 8, most - std::min(most, bulk));
  std::size_t for_below = below, for_above = above;
  if (below + above > strays) {
    for_below = strays * below / (below + above);
    if (below > 0 && above > 0 && strays > 1) for_below = std::clamp<std::size_t>(for_below, 1, strays - 1);
    for_above = strays - for_below;
  }
  std::vector<double> values = values_for(all.first(low), for_below);
  for (const auto& part : {values_for(all.subspan(low, bulk), most - for_below - for_above),
                           values_for(all.subspan(high), for_above)})
    values.insert(values.end(), part.begin(), part.end());
  book.set(values);
  return book;
}

void Codebook::set(const std::vector<double>& ascending) {
  for (std::size_t i = 0; i < values_.size(); ++i)
    values_[i] = float(ascending[std::min(i, ascending.size() - 1)]);
  for (std::size_t i = 0; i < bounds_.size(); ++i)
    bounds_[i] = float((double(values_[i]) + values_[i + 1]) / 2);
}

std::uint8_t Codebook::byte_of(float value) const {
  return std::uint8_t(std::lower_bound(bounds_.begin(), bounds_.end(), value) - bounds_.begin());
}

void Codebook::prepend(float value) {
  std::vector<double> ascending{value};
  ascending.insert(ascending.end(), values_.begin(), values_.end() - 1);
  set(ascending);
}

}  // namespace swiftgs::io
