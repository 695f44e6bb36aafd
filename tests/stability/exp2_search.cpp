// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "stability/targets.hpp"
#include "stability/ulps.hpp"

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "stability/exp2_search.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "exp2-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// `Exp2` of `count` floats, a multiple of 16.
void Exp2All(const float* HWY_RESTRICT in, std::size_t count, float* HWY_RESTRICT out) {
  const hn::CappedTag<float, 16> d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) hn::StoreU(Exp2(d, hn::LoadU(d, in + i)), d, out + i);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(Exp2All);
}

namespace test {
namespace {

float from_bits(std::uint32_t bits) {
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

/// Floats that are judged together. Double has 29 bits more than float and is exact enough here.
class Block {
 public:
  explicit Block(Targets& targets) : targets_(targets), worst_(targets.size()), at_(targets.size()) {}

  void add(float v) {
    in_.push_back(v);
    if (in_.size() == size) judge();
  }
  void judge() {
    if (in_.empty()) return;
    in_.resize(size, 0.0f);
    for (std::size_t i = 0; i < size; ++i) exact_[i] = std::exp2(double(in_[i]));
    for (std::size_t t = 1; t < targets_.size(); ++t) {
      targets_.on(t, [&](auto&) { HWY_DYNAMIC_DISPATCH(Exp2All)(in_.data(), size, out_); });
      for (std::size_t i = 0; i < size; ++i) {
        // Ulps of the power's exact value; it lies in [2^k, 2^(k + 1)), where floats are 2^(k - 23) apart.
        std::uint64_t bits = 0;
        std::memcpy(&bits, &exact_[i], sizeof bits);
        bits = (bits & 0x7ff0000000000000u) - (std::uint64_t(23) << 52);
        double spacing = 0;
        std::memcpy(&spacing, &bits, sizeof spacing);
        const double error = std::abs(double(out_[i]) - exact_[i]);
        if (error > worst_[t] * spacing) worst_[t] = error / spacing, at_[t] = in_[i];
      }
    }
    in_.clear();
  }
  double worst(std::size_t t) const { return worst_[t]; }
  float at(std::size_t t) const { return at_[t]; }

 private:
  static constexpr std::size_t size = 1 << 15;
  Targets& targets_;
  std::vector<float> in_;
  double exact_[size] = {};
  float out_[size] = {};
  std::vector<double> worst_;
  std::vector<float> at_;
};

}  // namespace

std::vector<Worst> search_exp2(int effort) {
  Targets targets;
  const auto block = std::make_unique<Block>(targets);
  // The polynomial sees v - round(v) alone, so [-1/2, 1/2] holds every case. Take every float of it down to
  // 2^-16, or every eighth; nearer to 0 the polynomial is 1 + v ln 2.
  const std::uint32_t step = effort > 1 ? 1 : 8;
  for (std::uint32_t bits = 0x37800000u; bits <= 0x3f000000u; bits += step)
    block->add(from_bits(bits)), block->add(-from_bits(bits));
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
  std::vector<Worst> all;
  for (std::size_t t = 1; t < targets.size(); ++t)
    all.push_back({"`Exp2`", "ulps", targets.name(t), block->worst(t), text("v %.9g", double(block->at(t)))});
  return all;
}

}  // namespace test
}  // namespace swiftgs
#endif
