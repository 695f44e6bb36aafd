// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A backend on the host that behaves as one on a device does: its memory is filled and read by copies alone,
/// its frames have limits, and messages go by way of other memory.

#include <string_view>
#include <type_traits>
#include <vector>

#include <swiftgs/mpi.hpp>
#include <swiftgs/serial.hpp>

namespace swiftgs::test {

class Away : public Serial {
 public:
  static constexpr std::string_view name = "away";
  static constexpr bool reaches_host_memory = false;
  using Serial::Serial;

  template <class Key>
  void sort_pairs(Pairs<Away, Key>& pairs, Count count, int bits) const {
    Pairs<Serial, Key> same;
    std::swap(same.keys, pairs.keys), std::swap(same.spare_keys, pairs.spare_keys);
    std::swap(same.values, pairs.values), std::swap(same.spare_values, pairs.spare_values);
    Serial::sort_pairs(same, count, bits);
    std::swap(same.keys, pairs.keys), std::swap(same.spare_keys, pairs.spare_keys);
    std::swap(same.values, pairs.values), std::swap(same.spare_values, pairs.spare_values);
  }
};

inline Views store_views(Away&, Span<const View> views, ViewStorage<Away>& storage,
                         ViewAccess = ViewAccess::any) {
  storage.each.assign(views.begin(), views.end());
  number_tiles({storage.each.data(), storage.each.size()});
  return {{storage.each.data(), storage.each.size()}, storage.each.data()};
}

template <BoundsPolicy Bounds>
FrameReport await_report(Away&, const Splats<Away>& splats, const Footprints<Away, Bounds>& footprints,
                         const Limits& limits) {
  FrameReport report{splats.visible, footprints.instances, 0};
  report.overflowed = !limits.fit(report);
  return report;
}

template <BoundsPolicy Bounds>
void bin(Away& away, const Views& views, const Bounds& bounds, Splats<Away>& splats,
         Footprints<Away, Bounds>& footprints, const Limits& = {}) {
  footprints.tiles = frame_tiles(views), footprints.views = views;
  footprints.each.reset(splats.count);
  footprints.count = splats.count, footprints.instances = 0;
  away.for_each(splats.count,
                FindFootprint<Bounds>{splats.view(), views.reachable(), bounds, footprints.each.data()});
  for (const Footprint& footprint : footprints.view().each) footprints.instances += footprint.count;
}

template <RasterPolicy R>
void rasterize(Away& away, R, const RasterJob& job) {
  const Squares squares = squares_of(job);
  away.for_each(squares.size(), RasterizeSquare<R>{job, squares});
}

inline void copy_from_host(Away&, const void* from, void* to, std::size_t bytes) {
  if (bytes != 0) std::memcpy(to, from, bytes);
}

}  // namespace swiftgs::test

namespace swiftgs {

template <class T>
class Staging<test::Away, T> {
 public:
  void reserve(test::Away&, Span<T> array) {
    array_ = array;
    host_.assign(array.size, T{});
  }
  T* host() { return host_.data(); }
  void to_host(test::Away&, std::size_t begin, std::size_t end) {
    std::copy(array_.data + begin, array_.data + end, host_.data() + begin);
  }
  void from_host(test::Away&, std::size_t begin, std::size_t end) {
    std::copy(host_.data() + begin, host_.data() + end, array_.data + begin);
  }
  static std::tuple<> buffers(auto&) { return {}; }

 private:
  Span<T> array_;
  std::vector<T> host_;
};

}  // namespace swiftgs
