// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A backend on the host that behaves as one on a device does: its memory is filled and read by copies alone,
/// its frames have limits, and messages go by way of other memory.

#include <algorithm>
#include <deque>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include <swiftgs/functor/blend.hpp>
#include <swiftgs/mpi.hpp>
#include <swiftgs/mpi/comm.hpp>
#include <swiftgs/serial.hpp>

namespace swiftgs::test {

class Away : public Serial {
 public:
  static constexpr std::string_view name = "away";
  static constexpr bool reaches_host_memory = false;
  using Serial::Serial;

  int failing_attribute = -1;  ///< the first of those that it throws for; -1: none

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

inline FrameReport await_report(Away&, const Splats<Away>& splats, const Footprints<Away>& footprints,
                                const Limits& limits) {
  FrameReport report{splats.visible, footprints.intersections, 0};
  report.overflowed = !limits.fit(report);
  return report;
}

template <BoundsPolicy Bounds>
void bin(Away& away, const FramePlan& plan, const Bounds& bounds, Splats<Away>& splats,
         Footprints<Away>& footprints) {
  footprints.views = plan.views;
  footprints.each.reset(splats.count);
  footprints.count = splats.count, footprints.intersections = 0;
  away.for_each(splats.count,
                FindFootprint<Bounds>{splats.view(), plan.views.reachable(), bounds, footprints.each.data()});
  for (const Footprint& footprint : footprints.view().each) footprints.intersections += footprint.count;
}

template <RasterPolicy R>
void rasterize(Away& away, R, const RasterJob& job) {
  const RasterBlocks blocks = raster_blocks_of(job);
  away.for_each(blocks.size(), BlendRasterBlock<R>{job, blocks});
}

inline void gather_attributes(Away& away, const SplatAttributes& from, const StoredScenes& scenes,
                              const Views& views, AttributeRow* to) {
  if (from.first == away.failing_attribute) throw std::runtime_error("thrown by a test");
  with_scenes(scenes, [&]<class Scenes>(const Scenes& of) {
    away.for_each(from.splats.count(), GatherAttributes<Scenes>{from, of, views.reachable(), to});
  });
}

inline void copy_from_host(Away&, const void* from, void* to, std::size_t bytes) {
  if (bytes != 0) std::memcpy(to, from, bytes);
}

/// A link from memory of `Away` to memory of `Away`, as one between devices: all that a rank names goes at
/// once.
class AwayLink : public DirectLink {
 public:
  /// `ranks` count what goes by it apart from what goes beside it.
  explicit AwayLink(Ranks ranks) : ranks_(std::move(ranks)) {}

  std::string_view name() const override { return "away"; }
  std::uint64_t begin(Span<const Message> messages, void*) override {
    Exchange& exchange = under_way_.emplace_back(ranks_);
    for (const Message& message : messages)
      message.from ? exchange.send(message.rank, message.from, message.bytes)
                   : exchange.receive(message.rank, message.to, message.bytes);
    return under_way_.size() - 1;
  }
  void order(std::uint64_t begun) override { under_way_[std::size_t(begun)].wait(); }
  bool test(std::uint64_t begun) override { return under_way_[std::size_t(begun)].test(); }

 private:
  Ranks ranks_;
  std::deque<Exchange> under_way_;
};

inline std::unique_ptr<DirectLink> direct_link(const Ranks& ranks, Away&) {
  return ranks.all(ranks.direct()) ? std::make_unique<AwayLink>(ranks_of(MPI_COMM_WORLD)) : nullptr;
}

}  // namespace swiftgs::test

namespace swiftgs {

template <class T>
class Staging<test::Away, T> {
 public:
  void reserve(test::Away&, Span<T> array, bool direct = false) {
    array_ = array, direct_ = direct;
    host_.assign(direct ? 0 : array.size, T{});
  }
  T* seen() { return direct_ ? array_.data : host_.data(); }
  void to_host(test::Away&, std::size_t begin, std::size_t end) {
    if (!direct_) std::copy(array_.data + begin, array_.data + end, host_.data() + begin);
  }
  void from_host(test::Away&, std::size_t begin, std::size_t end) {
    if (!direct_) std::copy(host_.data() + begin, host_.data() + end, array_.data + begin);
  }
  static std::tuple<> buffers(auto&) { return {}; }

 private:
  Span<T> array_;
  bool direct_ = false;
  std::vector<T> host_;
};

}  // namespace swiftgs
