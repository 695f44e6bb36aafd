// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include "formats/sog/sog_pixels.hpp"
#include "nearest_points.hpp"

namespace swiftgs::test::sog_palette_test {

using namespace swiftgs::io;

namespace {

const Progress nobody;
const ProgressMeter unheard(nobody, "");

std::vector<float> some_numbers(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> value(0, 1);
  std::vector<float> numbers(count);
  for (float& number : numbers) number = value(random);
  return numbers;
}

std::vector<std::uint32_t> all(std::size_t count) {
  std::vector<std::uint32_t> ids(count);
  std::iota(ids.begin(), ids.end(), 0);
  return ids;
}

double squared_distance(const Points& points, std::size_t i, const float* to) {
  double squared = 0;
  for (std::size_t k = 0; k < points.width; ++k) squared += std::pow(double(points[i][k]) - to[k], 2);
  return squared;
}

double error(const Points& points, const Palette& palette) {
  double sum = 0;
  for (std::size_t i = 0; i < points.count; ++i)
    sum += squared_distance(points, i, palette.colours.data() + palette.labels[i] * points.width);
  return sum;
}

/// k-means from points drawn at random, by Lloyd's rounds.
Palette lloyd(const Points& points, std::size_t count, int rounds) {
  Palette palette{.width = points.width};
  std::vector<std::uint32_t> ids = all(points.count);
  std::shuffle(ids.begin(), ids.end(), std::mt19937(3));
  for (std::size_t i = 0; i < count; ++i)
    palette.colours.insert(palette.colours.end(), points[ids[i]], points[ids[i]] + points.width);
  palette.labels.resize(points.count);
  for (int round = 0; round < rounds; ++round) {
    PointTable table;
    table.assign({palette.colours.data(), count, points.width}, all(count));
    find_nearest(points, all(points.count), table, palette.labels.data());
    std::vector<double> sums(palette.colours.size()), counts(count);
    for (std::size_t i = 0; i < points.count; ++i) {
      ++counts[palette.labels[i]];
      for (std::size_t k = 0; k < points.width; ++k)
        sums[palette.labels[i] * points.width + k] += points[i][k];
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
      if (counts[i / points.width] > 0) palette.colours[i] = float(sums[i] / counts[i / points.width]);
  }
  return palette;
}

/// The least sum of squared errors of `count` numbers, by trying every split.
double least_error(std::vector<float> numbers, std::size_t count) {
  std::sort(numbers.begin(), numbers.end());
  const std::size_t size = numbers.size();
  std::vector<double> costs(size + 1, std::numeric_limits<double>::infinity());
  costs[0] = 0;
  for (std::size_t run = 0; run < count; ++run) {
    std::vector<double> next = costs;
    for (std::size_t begin = 0; begin < size; ++begin) {
      double sum = 0, squares = 0;
      for (std::size_t end = begin + 1; end <= size; ++end) {
        sum += numbers[end - 1], squares += double(numbers[end - 1]) * numbers[end - 1];
        next[end] = std::min(next[end], costs[begin] + squares - sum * sum / double(end - begin));
      }
    }
    costs = next;
  }
  return costs[size];
}

double error(const std::vector<float>& numbers, const Codebook& codebook) {
  double sum = 0;
  for (const float number : numbers)
    sum += std::pow(double(number) - codebook.values()[codebook.byte_of(number)], 2);
  return sum;
}

std::vector<Occurrence> once(const std::vector<float>& numbers) {
  std::vector<Occurrence> result;
  for (const float number : numbers) result.push_back({number});
  return result;
}

}  // namespace

TEST_CASE("palette: the nearest of some points is found for every width") {
  for (std::size_t width = 1; width <= most_width; ++width) {
    CAPTURE(width);
    const std::vector<float> numbers = some_numbers(200 * width, unsigned(width));
    const Points points{numbers.data(), 200, width};
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t i = 0; i < 200; i += 2) candidates.push_back(199 - i);
    PointTable table;
    table.assign(points, candidates);
    std::vector<std::uint32_t> nearest(points.count);
    find_nearest(points, all(points.count), table, nearest.data());
    for (std::size_t i = 0; i < points.count; ++i) {
      double least = std::numeric_limits<double>::infinity();
      for (const std::uint32_t id : candidates)
        least = std::min(least, squared_distance(points, i, points[id]));
      REQUIRE(nearest[i] < candidates.size());
      CHECK(squared_distance(points, i, points[candidates[nearest[i]]]) <= least + 1e-4);
    }
  }
}

TEST_CASE("palette: sums of points are those of a plain loop for every width") {
  for (std::size_t width = 1; width <= most_width; ++width) {
    const std::vector<float> numbers = some_numbers(50 * width, unsigned(width));
    const Points points{numbers.data(), 50, width};
    const std::vector<std::uint32_t> ids{3, 49, 7, 7};
    Sums sums, expected;
    add_up(points, ids, sums);
    std::array<double, most_width> weighted{}, expected_weighted{};
    const std::vector<float> weights{1, -2, 0.5f, 3};
    add_weighted(points, ids, weights.data(), weighted);
    for (std::size_t i = 0; i < ids.size(); ++i)
      for (std::size_t k = 0; k < width; ++k) {
        const double value = points[ids[i]][k];
        expected.first[k] += value, expected.second += value * value;
        expected_weighted[k] += weights[i] * value;
      }
    CHECK(sums.second == doctest::Approx(expected.second));
    for (std::size_t k = 0; k < most_width; ++k) {
      CHECK(sums.first[k] == doctest::Approx(expected.first[k]));
      CHECK(weighted[k] == doctest::Approx(expected_weighted[k]));
    }
  }
}

TEST_CASE("palette: the error is well below that of ten rounds of k-means from random points") {
  for (const std::size_t width : {9, 24, 45}) {
    CAPTURE(width);
    // Some directions matter more than others, and some points lie far out, as in real scenes.
    std::vector<float> numbers = some_numbers(12'000 * width, 1);
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] *= (i / width % 50 == 0 ? 3.0f : 1.0f) / float(1 + i % width);
    const Points points{numbers.data(), 12'000, width};
    const Palette palette = make_palette(points, 1024, unheard);
    CHECK(palette.size() == 1024);
    CHECK(error(points, palette) < 0.93 * error(points, lloyd(points, 1024, 10)));
  }
}

TEST_CASE("palette: few different points are exact however often they occur") {
  const std::vector<float> different = some_numbers(500 * 45, 2);
  std::vector<float> numbers;
  for (std::size_t i = 0; i < 9000; ++i) {
    // The first makes up most of all.
    const std::size_t which = i % 10 == 0 ? i / 10 % 500 : 0;
    numbers.insert(numbers.end(), different.begin() + std::ptrdiff_t(which * 45),
                   different.begin() + std::ptrdiff_t(which * 45 + 45));
  }
  const Points points{numbers.data(), 9000, 45};
  const Palette palette = make_palette(points, 8192, unheard);
  CHECK(palette.size() == 500);
  CHECK(error(points, palette) == 0);
}

TEST_CASE("palette: groups hold every point once") {
  const std::vector<float> numbers = some_numbers(3000 * 9, 4);
  const Grouping groups = split_points({numbers.data(), 3000, 9}, 700, unheard);
  CHECK(groups.size() == 700);
  CHECK(groups.begins.front() == 0);
  CHECK(groups.begins.back() == 3000);
  for (std::size_t i = 0; i < groups.size(); ++i) CHECK(groups.begins[i] < groups.begins[i + 1]);
  CHECK(std::set<std::uint32_t>(groups.order.begin(), groups.order.end()).size() == 3000);
}

TEST_CASE("codebook: the error is the least that there is") {
  const std::vector<float> numbers = some_numbers(900, 5);
  for (const std::size_t count : {1, 2, 7, 64}) {
    CAPTURE(count);
    const Codebook codebook = Codebook::of(once(numbers), count);
    CHECK(error(numbers, codebook) == doctest::Approx(least_error(numbers, count)).epsilon(1e-5));
  }
}

TEST_CASE("codebook: the error of very many numbers is that of the best quantiser") {
  // Panter and Dite: a normal distribution in n steps has an error of sqrt(3) pi / 2 / n^2.
  const std::vector<float> numbers = some_numbers(400'000, 6);
  const Codebook codebook = Codebook::of(once(numbers));
  CHECK(error(numbers, codebook) / 400'000 < 1.01 * std::sqrt(3.0) * 3.14159265 / 2 / 65536);
}

TEST_CASE("codebook: 256 different numbers are exact whatever their size") {
  std::vector<float> numbers = some_numbers(250, 7);
  numbers.insert(numbers.end(), {3e38f, -3e38f, 1e20f, -1e-30f, 1e-30f, 0});
  std::vector<Occurrence> occurrences = once(numbers);
  for (Occurrence& occurrence : occurrences) occurrence.times = 1000;
  const Codebook codebook = Codebook::of(occurrences);
  for (const float number : numbers) CHECK(codebook.values()[codebook.byte_of(number)] == number);
}

TEST_CASE("codebook: a thousandth of strays leaves the others their values") {
  const std::vector<float> numbers = some_numbers(400'000, 6);
  std::vector<float> strayed = numbers;
  for (std::size_t i = 0; i < 400; ++i) strayed.push_back((i % 3 ? 1e4f : -1e4f) * float(i + 1));
  const Codebook codebook = Codebook::of(once(strayed));
  CHECK(error(numbers, codebook) < 1.6 * error(numbers, Codebook::of(once(numbers))));
  // Strays are apart from the others all the same.
  for (const float number : strayed)
    if (std::abs(number) > 1e6f) CHECK(codebook.values()[codebook.byte_of(number)] / number > 0.5f);
}

TEST_CASE("codebook: numbers count as often as they occur") {
  const Codebook codebook = Codebook::of({{0, 3}, {1, 1}, {10, 1}}, 2);
  CHECK(codebook.values()[0] == 0.25f);
  CHECK(codebook.values()[1] == 10);
}

TEST_CASE("codebook: a number that most have leaves room for thousands of others") {
  std::vector<float> numbers(100'000, 0.0f);
  for (std::size_t i = 0; i < 6000; ++i) numbers.push_back(1 + float(i) / 6000);
  numbers.push_back(1e9f);
  const Codebook codebook = Codebook::of(once(numbers));
  for (const float number : numbers)
    CHECK(std::abs(codebook.values()[codebook.byte_of(number)] - number) < 0.004);
}

}  // namespace swiftgs::test::sog_palette_test
