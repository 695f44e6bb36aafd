// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <swiftgs/scene.hpp>

/// @file
/// What writers do whose format cannot hold every number.

namespace swiftgs::io {

/// Takes the Gaussians out of `order` that have a number which is not finite, as it would spoil its
/// neighbours or have no byte. Notes how many they are.
void keep_renderable(const Scene& scene, std::vector<std::uint32_t>& order, std::vector<std::string>& notes);

/// Counts, from several threads, numbers that a format has to clamp.
class ClampCount {
 public:
  /// Counts if `clamped`, which it returns.
  bool operator()(bool clamped) {
    if (clamped) count_.fetch_add(1, std::memory_order_relaxed);
    return clamped;
  }

  /// Notes that so many `things` "are clamped to `range`", unless there are none.
  void note(const std::string& things, const std::string& range, std::vector<std::string>& notes) const;

 private:
  std::atomic<std::uint64_t> count_{0};
};

}  // namespace swiftgs::io
