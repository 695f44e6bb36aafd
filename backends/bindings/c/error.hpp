// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/c/status.h>
#include <swiftgs/error.hpp>

/// @file
/// The border that no exception crosses.

namespace swiftgs::c {

using swiftgs::detail::refuse;

/// Keeps the exception that is being handled as this thread's last error. Returns its status.
swiftgs_status keep_exception() noexcept;

/// Calls f(). Returns the status of the exception that it throws, or `SWIFTGS_OK`.
template <class F>
swiftgs_status guarded(const F& f) noexcept {
  try {
    f();
    return SWIFTGS_OK;
  } catch (...) {
    return keep_exception();
  }
}

/// Throws unless the caller gave a pointer for `what`.
inline void require_pointer(const void* pointer, const char* what) {
  if (!pointer) refuse(what, " is NULL, expected a pointer");
}

/// Throws unless a member without a meaning is 0, so that later versions can give it one.
inline void require_zero(std::uint32_t reserved, const char* what) {
  if (reserved != 0) refuse(what, ": reserved is ", reserved, ", expected 0");
}

/// Throws unless `value` is one of the `count` numbers of an enumeration that begins with 0.
inline void require_choice(std::int32_t value, std::int32_t count, const char* what) {
  if (value < 0 || value >= count) refuse(what, " is ", value, ", expected 0 to ", count - 1);
}

}  // namespace swiftgs::c
