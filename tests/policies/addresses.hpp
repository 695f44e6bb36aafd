// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A backend that runs no functor: its stages get addresses that the host cannot read, as those of a backend
/// that records commands for a device do.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <swiftgs/functor/stage_table.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/sort/early.hpp>

namespace swiftgs::test {

/// What no host address has. To read an address with it ends the program.
inline constexpr std::uintptr_t not_of_host = std::uintptr_t(1) << 62;

template <class T>
T* there(T* here) {
  return here ? reinterpret_cast<T*>(reinterpret_cast<std::uintptr_t>(here) | not_of_host) : here;
}
template <class T>
T* here(T* there) {
  return there ? reinterpret_cast<T*>(reinterpret_cast<std::uintptr_t>(there) & ~not_of_host) : there;
}
template <class T>
Span<T> here(Span<T> span) {
  return {here(span.data), span.size};
}

/// Memory that the host has the address of.
template <class T>
class AddressBuffer {
 public:
  void reset(std::size_t count) { memory_.reset(count); }
  void reset_exactly(std::size_t count) { memory_.reset_exactly(count); }
  T* data() { return there(memory_.data()); }
  const T* data() const { return there(memory_.data()); }
  std::size_t size() const { return memory_.size(); }
  std::size_t bytes() const { return memory_.bytes(); }
  Span<T> span() { return {data(), size()}; }
  Span<const T> span() const { return {data(), size()}; }
  void use(const MemoryHook& hook) { memory_.use(hook); }

  /// What stands behind the addresses, for stages alone.
  GrowingBuffer<T>& memory() { return memory_; }

 private:
  GrowingBuffer<T> memory_;
};

/// A scene there.
class AddressScene {
 public:
  explicit AddressScene(HostScene scene) : scene_(std::move(scene)) {}
  SceneView view() const {
    SceneView out = scene_.view();
    for_each_array([](const char*, std::size_t, auto& array) { array.data = there(array.data); }, out);
    out.chunks.data = there(out.chunks.data);
    return out;
  }

 private:
  HostScene scene_;
};

class Addresses {
 public:
  static constexpr std::string_view name = "addresses";
  template <class T>
  using Buffer = AddressBuffer<T>;
  using SceneOn = AddressScene;
  using TimePoint = Serial::TimePoint;
  static constexpr bool reaches_host_memory = false;

  static bool usable() { return true; }
  std::string device_name() const { return "addresses"; }
  SceneOn upload(Scene scene) const { return AddressScene(serial.upload(std::move(scene))); }
  template <class T>
  void download(Span<const T> from, T* to) const {
    serial.download(here(from), to);
  }
  void wait() const {}
  TimePoint now() const { return serial.now(); }
  std::optional<double> milliseconds(TimePoint from, TimePoint to) const {
    return serial.milliseconds(from, to);
  }

  Serial serial;
  bool overflowed = false;  ///< the last frame
};
static_assert(BackendPolicy<Addresses> && !FunctorBackend<Addresses>);

/// What stages of `Serial` see where `Addresses` has addresses.
struct PlanHere {
  std::vector<StoredScene> scenes;
  FramePlan plan;

  explicit PlanHere(const FramePlan& of)
      : scenes(of.scenes.each().begin(), of.scenes.each().end()), plan(of) {
    for (StoredScene& placed : scenes) {
      for_each_array([](const char*, std::size_t, auto& array) { array.data = here(array.data); },
                     placed.scene);
      placed.scene.chunks.data = here(placed.scene.chunks.data);
    }
    plan.scenes = StoredScenes(scenes);
  }
};
inline SplatsView here(const SplatsView& splats) {
  return {here(splats.shapes), here(splats.depths), here(splats.gaussians), here(splats.of_view)};
}

}  // namespace swiftgs::test

namespace swiftgs {

template <>
struct ProjectScratch<test::Addresses> {
  ProjectScratch<Serial> scratch;
  static auto buffers(auto& self) { return std::tie(self.scratch); }
};
template <>
struct Splats<test::Addresses> {
  Splats<Serial> splats;
  std::size_t count = 0;

  SplatsView view() const {
    const SplatsView of = splats.view();
    const auto span = [](auto s) { return decltype(s){test::there(s.data), s.size}; };
    return {span(of.shapes), span(of.depths), span(of.gaussians), test::there(of.of_view)};
  }
  static auto buffers(auto& self) { return std::tie(self.splats); }
};
template <>
struct Footprints<test::Addresses> {
  Footprints<Serial> footprints;
  Views views;

  FootprintsView view() const {
    FootprintsView of = footprints.view();
    of.each.data = test::there(of.each.data);
    return of;
  }
  static auto buffers(auto& self) { return std::tie(self.footprints); }
};

}  // namespace swiftgs

namespace swiftgs::test {

template <BoundsPolicy Bounds>
void project(Addresses& b, const FramePlan& plan, const Bounds& bounds, ProjectScratch<Addresses>& scratch,
             Splats<Addresses>& splats, Footprints<Addresses>& footprints) {
  const PlanHere frame(plan);
  swiftgs::project(b.serial, frame.plan, bounds, scratch.scratch, splats.splats, footprints.footprints);
  splats.count = splats.splats.count;
}
inline Shading<Addresses> shade(Addresses& b, const FramePlan& plan, const Splats<Addresses>& splats,
                                Colours<Addresses>& colours) {
  const PlanHere frame(plan);
  Colours<Serial> made;
  (void)swiftgs::shade(b.serial, frame.plan, splats.splats, made);
  std::swap(colours.each.memory(), made.each), std::swap(colours.colourless.memory(), made.colourless);
  return Shading<Addresses>({{colours.each.data(), splats.count}, colours.colourless.data()});
}
template <BoundsPolicy Bounds>
void bin(Addresses& b, const FramePlan& plan, const Bounds& bounds, Splats<Addresses>& splats,
         Footprints<Addresses>& footprints) {
  const PlanHere frame(plan);
  footprints.views = plan.views;
  swiftgs::bin(b.serial, frame.plan, bounds, splats.splats, footprints.footprints);
}
inline FrameReport await_report(Addresses& b, Splats<Addresses>& splats, Footprints<Addresses>& footprints,
                                const Limits& limits) {
  const FrameReport report = swiftgs::await_report(b.serial, splats.splats, footprints.footprints, limits);
  b.overflowed = report.overflowed != 0;
  return report;
}
inline void gather_attributes(Addresses& b, const SplatAttributes& from, const StoredScenes& scenes,
                              const Views& views, AttributeRow* to) {
  const PlanHere frame(FramePlan(views, scenes));
  swiftgs::gather_attributes(b.serial, {here(from.splats), from.first, from.rows}, frame.plan.scenes, views,
                             here(to));
}
inline const std::uint32_t* order_by_depth(Addresses& b, const SplatsView& splats,
                                           DepthOrderScratch<Addresses>& scratch) {
  DepthOrderScratch<Serial> sorted;
  swiftgs::order_by_depth(b.serial, here(splats), sorted);
  std::swap(scratch.pairs.values.memory(), sorted.pairs.values);
  return scratch.pairs.values.data();
}
template <BoundsPolicy Bounds>
void group_by_tile(Addresses& b, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                   GroupScratch<Addresses>&, TileLists<Addresses>& lists) {
  SortJob on_host = job;
  on_host.splats = here(job.splats), on_host.footprints.each = here(job.footprints.each);
  GroupScratch<Serial> scratch;
  TileLists<Serial> made;
  swiftgs::group_by_tile(b.serial, on_host, bounds, here(order), scratch, made);
  std::swap(lists.ids.memory(), made.ids), std::swap(lists.ranges.memory(), made.ranges);
  lists.intersections = made.intersections, lists.tiles = made.tiles;
}
/// Draws nothing of a frame that overflows: its splats are not all there.
template <RasterPolicy R>
void rasterize(Addresses& b, R, const RasterJob& job) {
  if (job.splats.size() == 0 && b.overflowed) return;
  std::vector<View> views(job.views.begin(), job.views.end());
  for (View& view : views) {
    for_each_plane([](std::size_t, auto& plane) { plane.data = here(plane.data); }, view.frame);
    view.frame.occluder.data = here(view.frame.occluder.data);
  }
  RasterJob on_host = job;
  on_host.splats = here(job.splats), on_host.colours = {here(job.colours.each), here(job.colours.colourless)};
  on_host.lists = {here(job.lists.ids), here(job.lists.ranges)};
  on_host.views = Views(views.data(), views.size());
  on_host.attributes.data = here(job.attributes.data);
  on_host.attributes.first_row = here(job.attributes.first_row);
  swiftgs::rasterize(b.serial, R{}, on_host);
}

}  // namespace swiftgs::test
