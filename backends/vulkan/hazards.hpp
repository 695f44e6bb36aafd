// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

namespace swiftgs::vulkan {

/// Memory that a dispatch reads or writes.
struct Access {
  std::uintptr_t begin = 0, end = 0;
  bool writes = false;
};
inline Access reads(const void* data, std::size_t bytes) {
  const auto begin = reinterpret_cast<std::uintptr_t>(data);
  return {begin, begin + bytes, false};
}
inline Access writes(const void* data, std::size_t bytes) {
  const auto begin = reinterpret_cast<std::uintptr_t>(data);
  return {begin, begin + bytes, true};
}

/// Derives barriers: a dispatch needs one if it touches what a dispatch since the last barrier wrote, or
/// writes what one touched. The only place that decides.
class Hazards {
 public:
  /// Notes the accesses of the next dispatch, and returns whether a barrier has to stand before it.
  bool next(std::initializer_list<Access> accesses) {
    bool conflict = false;
    for (const Access& now : accesses)
      for (const Access& before : since_barrier_)
        conflict =
            conflict || ((now.writes || before.writes) && now.begin < before.end && before.begin < now.end);
    if (conflict) since_barrier_.clear();
    since_barrier_.insert(since_barrier_.end(), accesses.begin(), accesses.end());
    return conflict;
  }

 private:
  std::vector<Access> since_barrier_;
};

}  // namespace swiftgs::vulkan
