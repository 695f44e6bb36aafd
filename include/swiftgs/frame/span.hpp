// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <swiftgs/frame/math.hpp>

namespace swiftgs {

/// Pointer and length. Unlike `std::span`, indexing is callable from device code without extra compiler
/// flags.
template <class T>
struct Span {
  T* data = nullptr;
  std::size_t size = 0;

  SWIFTGS_HD constexpr T& operator[](std::size_t i) const { return data[i]; }
  SWIFTGS_HD constexpr T* begin() const { return data; }
  SWIFTGS_HD constexpr T* end() const { return data + size; }
  SWIFTGS_HD constexpr bool empty() const { return size == 0; }
  SWIFTGS_HD constexpr Span first(std::size_t count) const { return {data, count}; }

  /// A view of mutable elements is also a view of constant ones.
  template <std::same_as<const T> U>
  SWIFTGS_HD constexpr operator Span<U>() const {
    return {data, size};
  }
};

template <class T>
Span(T*, std::size_t) -> Span<T>;

/// Fewer than 2^32 values, each `stride` bytes behind the one before it.
template <class T>
struct StridedSpan {
  T* data = nullptr;
  std::size_t size = 0;
  std::uint32_t stride = 0;  ///< @units{bytes}

  constexpr StridedSpan() = default;
  /// A stride of 4 GiB or more becomes one that no renderer takes.
  SWIFTGS_HD constexpr StridedSpan(T* first, std::size_t count, std::size_t bytes = sizeof(T))
      : data(first), size(count), stride(bytes >> 32 == 0 ? std::uint32_t(bytes) : ~0u) {}
  /// Values side by side.
  template <class U>
  requires std::same_as<const U, const T> SWIFTGS_HD constexpr StridedSpan(Span<U> values)
      : StridedSpan(values.data, values.size, values.data ? sizeof(T) : 0) {}

  /// Where value `i` lies, by a product of 32 bits, which is a device's quickest.
  SWIFTGS_HD T* at(std::size_t i) const {
    using Byte = std::conditional_t<std::is_const_v<T>, const unsigned char, unsigned char>;
    return reinterpret_cast<T*>(reinterpret_cast<Byte*>(data) + std::uint64_t(std::uint32_t(i)) * stride);
  }
  SWIFTGS_HD T& operator[](std::size_t i) const { return *at(i); }
  SWIFTGS_HD constexpr bool empty() const { return size == 0; }
  SWIFTGS_HD constexpr bool is_dense() const { return stride == sizeof(T); }
  /// `count` values from number `first` on. An empty span stays empty.
  SWIFTGS_HD StridedSpan part(std::size_t first, std::size_t count) const {
    return empty() ? *this : StridedSpan(at(first), count, stride);
  }
};

/// A number of elements. A device may know it before its host does: the host then launches work for
/// `most` elements, and the device works on `get()` elements.
struct Count {
  std::size_t most = 0;
  const std::uint32_t* exact = nullptr;  ///< in the backend's memory, at most `most`; null: it is `most`

  Count() = default;
  SWIFTGS_HD Count(std::size_t count, const std::uint32_t* known_there = nullptr)
      : most(count), exact(known_there) {}

  /// The number itself; call it where loops run.
  SWIFTGS_HD std::size_t get() const { return exact ? *exact : most; }
};

/// The capacity of a frame. 0: unlimited.
struct Capacity {
  std::size_t splats = 0;         ///< visible Gaussians of all views
  std::size_t intersections = 0;  ///< pairs of splat and tile
};

/// What a frame took. If it overflowed, it drew nothing; a capacity of these numbers suffices.
struct FrameReport {
  std::uint64_t visible = 0;        ///< Gaussians, of all views
  std::uint64_t intersections = 0;  ///< pairs of splat and tile; on hosts, of splats that fit
  std::uint64_t overflowed = 0;     ///< 1: they exceeded the capacity
};

/// Limits of a frame, and who learns of what it took.
struct Limits {
  Capacity capacity;
  bool draw = true;               ///< false: treat the frame as one that overflows
  FrameReport* report = nullptr;  ///< in memory that the backend reaches; null: the backend keeps it

  SWIFTGS_HD bool fit(const FrameReport& frame) const {
    return draw && (capacity.splats == 0 || frame.visible <= capacity.splats) &&
           (capacity.intersections == 0 || frame.intersections <= capacity.intersections);
  }
};

}  // namespace swiftgs
