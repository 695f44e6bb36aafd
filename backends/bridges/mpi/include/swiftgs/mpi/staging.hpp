// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstring>
#include <tuple>

#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// Copies from the host's memory into the backend's, after all work submitted so far. The host's memory must
/// not change until the backend has `wait`ed or downloaded something. A device overloads this.
template <BackendPolicy B>
requires(bool(B::reaches_host_memory)) void copy_from_host(B&, const void* from, void* to,
                                                           std::size_t bytes) {
  if (bytes != 0) std::memcpy(to, from, bytes);
}

/// Where messages find an array that lies in a backend's memory. Hosts, and devices with a `DirectLink`, send
/// from the array and receive into it; a backend of a device specialises this, and copies on the way to MPI.
template <class B, class T>
class Staging {
  static_assert(B::reaches_host_memory, "a device's backend specialises Staging");

 public:
  /// Takes what memory it needs for messages of `array`, none if they are `direct`, and remembers it.
  void reserve(B&, Span<T> array, bool /*direct*/ = false) { array_ = array; }
  /// The array as messages see it.
  T* seen() const { return array_.data; }
  /// Copies elements [begin, end) there, and waits for them.
  void to_host(B&, std::size_t, std::size_t) {}
  /// Copies them back, in the order of the backend's work.
  void from_host(B&, std::size_t, std::size_t) {}

  static std::tuple<> buffers(auto&) { return {}; }

 private:
  Span<T> array_;
};

}  // namespace swiftgs
