// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Floating-point environments other than the default one.

#include <cfenv>
#include <string_view>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace swiftgs::test {

/// A mode of rounding, and whether denormal numbers are taken and given as zero.
struct Environment {
  std::string_view name;
  int rounding;
  bool flush = false;
  bool vectors_alone = false;  ///< on x86 the mode is that of MXCSR, and the x87 rounds to nearest
};
/// The usual one is the first.
inline constexpr Environment environments[] = {
    {.name = "to nearest", .rounding = FE_TONEAREST},
    {.name = "upward", .rounding = FE_UPWARD},
    {.name = "downward", .rounding = FE_DOWNWARD},
    {.name = "towards zero", .rounding = FE_TOWARDZERO},
    {.name = "flush to zero", .rounding = FE_TONEAREST, .flush = true},
    {.name = "flush to zero upward", .rounding = FE_UPWARD, .flush = true},
#if defined(__SSE__)
    {.name = "vectors to nearest", .rounding = FE_TONEAREST, .vectors_alone = true},
    {.name = "vectors upward", .rounding = FE_UPWARD, .vectors_alone = true},
    {.name = "vectors downward", .rounding = FE_DOWNWARD, .vectors_alone = true},
    {.name = "vectors towards zero", .rounding = FE_TOWARDZERO, .vectors_alone = true},
#endif
};

/// Sets the environment of this thread until it is destroyed.
class ScopedEnvironment {
 public:
  explicit ScopedEnvironment(const Environment& environment) {
    std::fegetenv(&saved_);
    std::fesetround(environment.rounding);
#if defined(__SSE__)
    // Bit 15 flushes results, bit 6 takes denormal operands as zero.
    const unsigned vectors = _mm_getcsr() | (environment.flush ? 0x8040 : 0);
    if (environment.vectors_alone) std::fesetround(FE_TONEAREST);
    _mm_setcsr(vectors);
#endif
  }
  ~ScopedEnvironment() { std::fesetenv(&saved_); }
  ScopedEnvironment(const ScopedEnvironment&) = delete;
  ScopedEnvironment& operator=(const ScopedEnvironment&) = delete;

 private:
  std::fenv_t saved_;
};

}  // namespace swiftgs::test
