// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <swiftgs/count.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// Throws `CapacityError` where a frame has more intersections than a tile list can index.
inline void check_intersections(std::uint64_t total) {
  if (total > max_intersections) throw CapacityError("intersections in one frame", total, max_intersections);
}

/// `count` and an eighth more, so that the next frame need not grow.
inline std::size_t with_spare(std::uint64_t count) { return std::size_t(count + count / 8 + 1); }

/// The capacity of a device's frames. It grows with them.
class FrameCapacity {
 public:
  /// Calls draw(capacity) until the `FrameReport` that it returns has not overflowed. Returns the last
  /// report. Throws `CapacityError` beyond `max_intersections`. If it throws, the capacity stays as it was:
  /// otherwise the next frame would ask for the memory that this one did not get.
  template <class Draw>
  FrameReport draw_until_it_fits(const Draw& draw) {
    const Capacity before = capacity_;
    try {
      for (;;) {
        const FrameReport report = draw(capacity_);
        if (report.overflowed == 0) return report;
        grow(report);
      }
    } catch (...) {
      capacity_ = before;
      throw;
    }
  }

  /// Grows to `capacity` where that is more.
  void at_least(const Capacity& capacity) {
    capacity_.splats = std::max(capacity_.splats, capacity.splats);
    capacity_.intersections = std::max(capacity_.intersections, capacity.intersections);
  }

 private:
  /// Grows to the numbers of `report` plus an eighth.
  void grow(const FrameReport& report) {
    check_intersections(report.intersections);
    at_least({with_spare(report.visible),
              std::min(with_spare(report.intersections), std::size_t(max_intersections))});
  }

  Capacity capacity_{1, 1};
};

}  // namespace swiftgs
