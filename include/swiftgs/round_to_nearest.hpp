// SPDX-License-Identifier: Apache-2.0
#pragma once

#if defined(__SSE2_MATH__)
#include <xmmintrin.h>
#else
#include <cfenv>
#endif

namespace swiftgs {

/// Until it is destroyed, this thread rounds floats to nearest, whatever mode the caller has set. On x86 it
/// keeps denormal numbers as well.
class RoundToNearest {
 public:
#if defined(__SSE2_MATH__)
  // Floats obey MXCSR, which a program may set alone. std::fegetround reads the word of the x87 instead.
  RoundToNearest() : saved_(_mm_getcsr()) {
    if ((saved_ & unusual) != 0) _mm_setcsr(saved_ & ~unusual);
  }
  ~RoundToNearest() {
    // Exceptions that were raised meanwhile stay flagged.
    if ((saved_ & unusual) != 0) _mm_setcsr((_mm_getcsr() & ~unusual) | (saved_ & unusual));
  }
#else
  RoundToNearest() : saved_(std::fegetround()) {
    if (saved_ != FE_TONEAREST) std::fesetround(FE_TONEAREST);
  }
  ~RoundToNearest() {
    if (saved_ != FE_TONEAREST) std::fesetround(saved_);
  }
#endif
  RoundToNearest(const RoundToNearest&) = delete;
  RoundToNearest& operator=(const RoundToNearest&) = delete;

 private:
#if defined(__SSE2_MATH__)
  /// The two bits of the mode, and those that take results and operands that are denormal for zero.
  static constexpr unsigned unusual = 0x6000 | 0x8000 | 0x0040;
  unsigned saved_;
#else
  int saved_;
#endif
};

}  // namespace swiftgs
