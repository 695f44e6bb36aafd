// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The search for what an approximation of 2^v errs most on.

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace swiftgs::test {

/// Floats that are judged together. Double has 29 bits more than float and is exact enough here.
/// `exp2` is a function (target, floats in, count, floats out).
template <class Exp2>
class Exp2Judge {
 public:
  struct Worst {
    double ulps = 0;
    float at = 0;
  };

  Exp2Judge(std::size_t targets, Exp2 exp2) : exp2_(std::move(exp2)), worst_(targets) {}

  void add(float v) {
    in_.push_back(v);
    if (in_.size() == size) judge();
  }
  void judge() {
    if (in_.empty()) return;
    in_.resize(size, 0.0f);
    for (std::size_t i = 0; i < size; ++i) exact_[i] = std::exp2(double(in_[i]));
    for (std::size_t t = 0; t < worst_.size(); ++t) {
      exp2_(t, in_.data(), size, out_);
      for (std::size_t i = 0; i < size; ++i) {
        // Ulps of the power's exact value; it lies in [2^k, 2^(k + 1)), where floats are 2^(k - 23) apart.
        const auto power = std::bit_cast<std::uint64_t>(exact_[i]) & 0x7ff0000000000000u;
        const auto spacing = std::bit_cast<double>(power - (std::uint64_t(23) << 52));
        const double error = std::abs(double(out_[i]) - exact_[i]);
        if (error > worst_[t].ulps * spacing) worst_[t] = {error / spacing, in_[i]};
      }
    }
    in_.clear();
  }
  const std::vector<Worst>& worst() const { return worst_; }

 private:
  static constexpr std::size_t size = 1 << 15;
  Exp2 exp2_;
  std::vector<float> in_;
  double exact_[size] = {};
  float out_[size] = {};
  std::vector<Worst> worst_;
};

/// The worst of each target over [-126, 126].
template <class Exp2>
auto worst_of_exp2(std::size_t targets, const Exp2& exp2, int effort) {
  const auto block = std::make_unique<Exp2Judge<Exp2>>(targets, exp2);
  // The polynomial sees v - round(v) alone, so [-1/2, 1/2] holds every case. Take every float of it down to
  // 2^-16, or every eighth; nearer to 0 the polynomial is 1 + v ln 2.
  const std::uint32_t step = effort > 1 ? 1 : 8;
  for (std::uint32_t bits = 0x37800000u; bits <= 0x3f000000u; bits += step) {
    const auto v = std::bit_cast<float>(bits);
    block->add(v), block->add(-v);
  }
  // Whole exponents of the range, with the floats around each half, where rounding changes sides.
  for (int n = -126; n < 126; ++n)
    for (int k = 0; k < 4096; ++k) block->add(float(n) + float(k) / 4096);
  for (int n = -126; n < 126; ++n) {
    float below = float(n) + 0.5f, above = below;
    for (int k = 0; k < 16; ++k) {
      block->add(below), block->add(above);
      below = std::nextafter(below, -200.0f), above = std::nextafter(above, 200.0f);
    }
  }
  block->add(126), block->judge();
  return block->worst();
}

}  // namespace swiftgs::test
