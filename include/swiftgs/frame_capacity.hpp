// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <swiftgs/count.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// Throws `CapacityError` where a frame has more instances than a tile list can index.
inline void check_instances(std::uint64_t total) {
  if (total > max_instances) throw CapacityError("instances in one frame", total, max_instances);
}

/// Room for `count` and an eighth more, so that the next frame need not grow.
inline std::size_t with_room(std::uint64_t count) { return std::size_t(count + count / 8 + 1); }

/// What a device's frames have room for; grows with them.
class FrameCapacity {
 public:
  /// Calls draw(capacity), which returns a `FrameReport`, until the frame does not overflow; one that does
  /// draws nothing. Returns the last report. Throws `CapacityError` beyond `max_instances`; if it or `draw`
  /// throws, the capacity is that of before, or the next frame would ask for the memory that this one did not
  /// get.
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
    capacity_.instances = std::max(capacity_.instances, capacity.instances);
  }

 private:
  /// Grows to the numbers of `report` plus an eighth.
  void grow(const FrameReport& report) {
    check_instances(report.instances);
    at_least({with_room(report.visible), std::min(with_room(report.instances), std::size_t(max_instances))});
  }

  Capacity capacity_{1, 1};
};

}  // namespace swiftgs
