// SPDX-License-Identifier: Apache-2.0

// Vector conversions against the scalar functions, on every target of the machine.
// tests/stability searches for the errors of the exponential.
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/frame/half.hpp>

#include "policies/only_targets.hpp"

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "policies/cpu_arithmetic_test.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "half-inl.hpp"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::HWY_NAMESPACE {

/// `ToHalf` of `count` floats, a multiple of 16.
void ToHalfAll(const float* HWY_RESTRICT in, std::size_t count, std::uint16_t* HWY_RESTRICT out) {
  for (std::size_t i = 0; i < count; i += lanes) hn::StoreU(ToHalf(hn::LoadU(F32(), in + i)), U16(), out + i);
}

/// `ToFloat` of `count` halves, a multiple of 16.
void ToFloatAll(const std::uint16_t* HWY_RESTRICT in, std::size_t count, float* HWY_RESTRICT out) {
  for (std::size_t i = 0; i < count; i += lanes)
    hn::StoreU(ToFloat(hn::BitCast(F16(), hn::LoadU(U16(), in + i))), F32(), out + i);
}

}  // namespace swiftgs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs {
namespace {
HWY_EXPORT(ToHalfAll);
HWY_EXPORT(ToFloatAll);
}  // namespace

TEST_CASE("cpu arithmetic: every vector target rounds to the halves of the scalar conversion") {
  // All halves, what lies between neighbours, and the floats beside that; then every magnitude, also beyond
  // the largest half. What is not a number may have any payload, and is no colour and no term.
  std::vector<float> in;
  for (std::uint32_t bits = 0; bits < 0x7c00; ++bits) {
    const float value = to_float(Half{std::uint16_t(bits)});
    const float next = bits == 0x7bff ? 65536.0f : to_float(Half{std::uint16_t(bits + 1)});
    const float tie = value + (next - value) / 2;
    for (const float v : {value, tie, std::nextafter(tie, 0.0f), std::nextafter(tie, INFINITY)})
      in.push_back(v), in.push_back(-v);
  }
  for (std::uint64_t bits = 0; bits <= 0xffffffffu; bits += 4099) {
    const float v = std::bit_cast<float>(std::uint32_t(bits));
    if (!std::isnan(v)) in.push_back(v);
  }
  in.resize((in.size() + 15) / 16 * 16, INFINITY);
  std::vector<std::uint16_t> out(in.size());
  test::on_each_target([&] {
    HWY_DYNAMIC_DISPATCH(ToHalfAll)(in.data(), in.size(), out.data());
    std::size_t other = 0;
    for (std::size_t i = 0; i < in.size(); ++i) other += out[i] != to_half(in[i]).bits;
    CHECK(other == 0);
  });
}

TEST_CASE("cpu arithmetic: every vector target reads halves as the scalar conversion does") {
  // All that are numbers, the infinite ones included: no term is anything else.
  std::vector<std::uint16_t> in;
  for (std::uint32_t bits = 0; bits < 65536; ++bits)
    if (!std::isnan(to_float(Half{std::uint16_t(bits)}))) in.push_back(std::uint16_t(bits));
  in.resize((in.size() + 15) / 16 * 16);
  std::vector<float> out(in.size());
  test::on_each_target([&] {
    HWY_DYNAMIC_DISPATCH(ToFloatAll)(in.data(), in.size(), out.data());
    std::size_t other = 0;
    for (std::size_t i = 0; i < in.size(); ++i)
      other += std::bit_cast<std::uint32_t>(out[i]) != std::bit_cast<std::uint32_t>(to_float(Half{in[i]}));
    CHECK(other == 0);
  });
}

}  // namespace swiftgs
#endif
