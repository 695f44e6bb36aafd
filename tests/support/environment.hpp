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
  bool flush;
};
inline constexpr Environment environments[] = {
    {"to nearest", FE_TONEAREST, false},   {"upward", FE_UPWARD, false},
    {"downward", FE_DOWNWARD, false},      {"towards zero", FE_TOWARDZERO, false},
    {"flush to zero", FE_TONEAREST, true}, {"flush to zero upward", FE_UPWARD, true},
};

/// Sets the environment of this thread until it is destroyed.
class ScopedEnvironment {
 public:
  explicit ScopedEnvironment(const Environment& environment) {
    std::fegetenv(&saved_);
    std::fesetround(environment.rounding);
#if defined(__SSE__)
    // Bit 15 flushes results, bit 6 takes denormal operands as zero.
    if (environment.flush) _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
  }
  ~ScopedEnvironment() { std::fesetenv(&saved_); }
  ScopedEnvironment(const ScopedEnvironment&) = delete;
  ScopedEnvironment& operator=(const ScopedEnvironment&) = delete;

 private:
  std::fenv_t saved_;
};

}  // namespace swiftgs::test
