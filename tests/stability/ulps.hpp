// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Errors of single stages, in ulps of float.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

namespace swiftgs::test {

/// Exact values are computed in this type: 40 bits more than a float has.
using Real = long double;
static_assert(std::numeric_limits<Real>::digits >= 64, "exact values need a long double beyond double");

/// Distance of neighbouring floats at `value`.
inline Real ulp(Real value) {
  int exponent = 0;
  std::frexp(value, &exponent);
  return std::ldexp(Real(1), std::max(exponent - 24, -149));
}

/// For each result the sum over all inputs of how far it moves if one input moves by its step, up or down. A
/// stage cannot be asked for less, since its inputs were rounded too. `f` turns inputs into an array.
template <class F, std::size_t N>
auto moves(const F& f, std::array<Real, N> inputs, const std::array<Real, N>& steps) {
  const auto base = f(inputs);
  auto sum = base;
  sum.fill(0);
  for (std::size_t i = 0; i < N; ++i) {
    const Real at = inputs[i];
    inputs[i] = at + steps[i];
    const auto up = f(inputs);
    inputs[i] = at - steps[i];
    const auto down = f(inputs);
    inputs[i] = at;
    for (std::size_t k = 0; k < base.size(); ++k)
      sum[k] += std::max(std::abs(up[k] - base[k]), std::abs(down[k] - base[k]));
  }
  return sum;
}

/// How far the result of `f` moves if all inputs move by their steps at once: inputs take turns to choose the
/// side that leads furthest. Results that are squares, as a determinant near its least, hardly move with
/// single inputs.
template <class F, std::size_t N>
Real joint_move(const F& f, std::array<Real, N> inputs, const std::array<Real, N>& steps) {
  const Real base = f(inputs);
  Real furthest = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const Real at = inputs[i];
    Real best = -1, chosen = at;
    for (const Real side : {at + steps[i], at - steps[i]}) {
      inputs[i] = side;
      const Real move = std::abs(f(inputs) - base);
      if (move > best) best = move, chosen = side;
    }
    inputs[i] = chosen;
    furthest = std::max(furthest, best);
  }
  return furthest;
}

template <std::size_t N>
std::array<Real, N> ulps_of(const std::array<Real, N>& values) {
  std::array<Real, N> steps;
  std::transform(values.begin(), values.end(), steps.begin(), ulp);
  return steps;
}

/// The largest error that a search found for one stage on one target.
struct Worst {
  std::string stage, yardstick, target;
  double ulps = 0;
  std::string at;  ///< the inputs
};

/// Numbers as text, enough digits to read the same floats again.
template <class... T>
std::string text(const char* format, T... values) {
  char line[600];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

/// Without the rows of what hosts alone compute, where a device is searched.
inline std::vector<Worst> rows_of_targets(std::vector<Worst> rows) {
#if defined(SWIFTGS_SEARCH_ON_DEVICE)
  rows.erase(std::remove_if(rows.begin(), rows.end(), [](const Worst& row) { return row.target != "cuda"; }),
             rows.end());
#endif
  return rows;
}

/// The searches of each file. `effort` is how often each is repeated with other seeds: tests take 1, the
/// table 4.
std::vector<Worst> search_projection(int effort);
std::vector<Worst> search_harmonics(int effort);
std::vector<Worst> search_exp2(int effort);
std::vector<Worst> search_alpha(int effort);
std::vector<Worst> search_transmittance(int effort);

}  // namespace swiftgs::test
