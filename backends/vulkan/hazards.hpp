// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/frame/span.hpp>

namespace swiftgs::vulkan {

/// Memory that a dispatch reads or writes. Null is none.
struct Access {
  enum How { read, written, shared };

  std::uintptr_t begin = 0, end = 0;
  How how = read;

  template <class T>
  Access(const T* data, std::size_t count, How as)
      : begin(reinterpret_cast<std::uintptr_t>(data)), end(data ? begin + count * sizeof(T) : 0), how(as) {}

  bool operator==(const Access&) const = default;
  /// Whether one has to wait for the other. Dispatches that share memory write to places of their own, or by
  /// atomics.
  bool conflicts_with(const Access& other) const {
    return (how != other.how || how == written) && begin < other.end && other.begin < end;
  }
};
template <class T>
Access reads(const T* data, std::size_t count) {
  return {data, count, Access::read};
}
template <class T>
Access writes(const T* data, std::size_t count) {
  return {data, count, Access::written};
}
template <class T>
Access shares(const T* data, std::size_t count) {
  return {data, count, Access::shared};
}

/// An address of memory that no kernel writes, or whose accesses are told apart.
inline Access address(const void* data) { return {static_cast<const std::byte*>(data), 0, Access::read}; }

/// Derives barriers: a dispatch needs one if it touches what a dispatch since the last barrier wrote, or
/// writes memory that a dispatch since then read or wrote. The only place that decides.
class Hazards {
 public:
  /// What came before is not known: the next dispatch needs a barrier.
  void forget() { unknown_ = true, since_barrier_.clear(); }

  /// Notes the accesses of the next dispatch, and returns whether a barrier has to stand before it.
  bool next(Span<const Access> accesses) {
    bool conflict = unknown_ || since_barrier_.size() > most;
    for (const Access& now : accesses)
      for (const Access& before : since_barrier_) conflict = conflict || now.conflicts_with(before);
    if (conflict) since_barrier_.clear(), unknown_ = false;
    for (const Access& now : accesses)
      if (now.begin != now.end &&
          std::find(since_barrier_.begin(), since_barrier_.end(), now) == since_barrier_.end())
        since_barrier_.push_back(now);
    return conflict;
  }

 private:
  /// Of so many, one barrier more costs less than looking through them for each dispatch.
  static constexpr std::size_t most = 256;

  bool unknown_ = true;
  std::vector<Access> since_barrier_;
};

}  // namespace swiftgs::vulkan
