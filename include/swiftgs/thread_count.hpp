// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/message.hpp>

namespace swiftgs {

/// Throws `InvalidArgument` for a negative number of threads, of whatever backend.
inline void require_thread_count(int threads) {
  if (threads < 0) detail::refuse("backend: threads is ", threads, ", expected 1 or more, or 0 for all");
}

}  // namespace swiftgs
