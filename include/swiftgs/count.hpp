// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/math.hpp>

namespace swiftgs {

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
