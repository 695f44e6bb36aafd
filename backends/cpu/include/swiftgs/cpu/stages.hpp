// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include <swiftgs/bounds/ellipse.hpp>
#include <swiftgs/bounds/opacity_box.hpp>
#include <swiftgs/bounds/three_sigma_square.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/bounds.hpp>
#include <swiftgs/frame/sort.hpp>
#include <swiftgs/functor/bounds_stages.hpp>
#include <swiftgs/functor/shade_stage.hpp>
#include <swiftgs/memory/growing_buffer.hpp>
#include <swiftgs/memory/host_scene.hpp>
#include <swiftgs/raster/axis_shared.hpp>
#include <swiftgs/raster/per_pixel.hpp>
#include <swiftgs/raster/split.hpp>

namespace swiftgs {

/// Memory in large pages where the system grants them: visits in depth order would mostly miss the address
/// translation of small pages. Throws `std::bad_alloc`.
struct SWIFTGS_API LargePageMemory {
  static void* allocate(std::size_t bytes);
  static void release(void* memory);
};

/// When the system moves the arrays that `Cpu::upload` is given to large pages.
enum class LargePages {
  later,  ///< at some time after `upload` returns, or never
  now,    ///< before `upload` returns, which waits for the move
};

/// All cores, by oneTBB, with vector kernels that are chosen for the processor at run time. A frame has the
/// same bits whatever the number of threads, and whatever mode of rounding the calling thread has set.
class SWIFTGS_API Cpu {
 public:
  static constexpr std::string_view name = "cpu";
  template <class T>
  using Buffer = GrowingBuffer<T, LargePageMemory>;
  using SceneOn = HostScene;
  using TimePoint = std::chrono::steady_clock::time_point;

  /// `threads`: how many run at once, at most what oneTBB allows; 0: all. Each backend has its own arena, so
  /// renderers and other users of oneTBB do not disturb each other. oneTBB does not take memory of its tasks
  /// from `memory`. Throws `InvalidArgument` for a negative number of threads.
  explicit Cpu(int threads = 0, const MemoryHook& memory = hook_of<LargePageMemory>());
  ~Cpu();
  Cpu(Cpu&&) noexcept;
  Cpu& operator=(Cpu&&) noexcept;

  static constexpr bool reaches_host_memory = true;

  static bool usable() { return true; }
  const MemoryHook& memory_hook() const { return memory_; }
  int threads() const;
  std::string device_name() const;

  /// Shares `scene` without a copy, or takes it over: then harmonics are kept in the fewest bytes that are
  /// exact. Reads all numbers once, to validate them and to bound chunks. Advises the system to move the
  /// arrays, the caller's memory included, to large pages. @sync Complete when it returns, but for
  /// `LargePages::later`.
  SceneOn upload(std::shared_ptr<const Scene> scene, HarmonicsKept kept = HarmonicsKept::smallest,
                 LargePages pages = LargePages::later) const;
  SceneOn upload(Scene scene, HarmonicsKept kept = HarmonicsKept::smallest,
                 LargePages pages = LargePages::later) const;
  /// As `HostScene::copy`.
  SceneOn upload(const SceneArrays& arrays, std::optional<SceneOn>& reuse) const;
  /// As `HostScene::update`.
  void update(SceneOn& scene, std::size_t first, const SceneArrays& arrays) const;

  template <class T>
  void download(Span<const T> from, T* to) const {
    std::copy(from.begin(), from.end(), to);
  }

  void wait() const {}  // loops are complete when they return

  /// f(begin, end) for consecutive parts of [0, n) of at least `grain` elements, in parallel.
  template <class F>
  void for_parts(std::size_t n, std::size_t grain, const F& f) const {
    run(n, grain, {&f, [](const void* loop, std::size_t begin, std::size_t end) {
                     (*static_cast<const F*>(loop))(begin, end);
                   }});
  }

  template <class F>
  void for_each(Count n, const F& f) const {
    for_parts(n.get(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) f(i);
    });
  }

  std::uint64_t exclusive_scan(Span<std::uint32_t> counts);

  /// Radix sort, leading digit first; bits that all keys share are not sorted by.
  void sort_pairs(Pairs<Cpu, std::uint32_t>& pairs, Count count, int bits);
  void sort_pairs(Pairs<Cpu, std::uint64_t>& pairs, Count count, int bits);

  /// As `swiftgs::reserve_sort`.
  void reserve_sort(std::size_t pairs);
  /// Gives back the memory that sorts keep.
  void trim() { histograms_.trim(); }

  TimePoint now() const { return std::chrono::steady_clock::now(); }
  std::optional<double> milliseconds(TimePoint from, TimePoint to) const {
    return std::chrono::duration<double, std::milli>(to - from).count();
  }

 private:
  /// A function of a part, without its type: oneTBB stays out of this header.
  struct PartLoop {
    const void* loop;
    void (*call)(const void* loop, std::size_t begin, std::size_t end);
  };
  void run(std::size_t n, std::size_t grain, PartLoop part) const;

  struct Arena;
  std::unique_ptr<Arena> arena_;
  MemoryHook memory_;
  Buffer<std::uint32_t> histograms_;  ///< of `sort_pairs`, kept from frame to frame
};

inline Cpu make_backend(std::type_identity<Cpu>, const BackendOptions& options) {
  return options.memory ? Cpu(options.threads, *options.memory) : Cpu(options.threads);
}

static_assert(FunctorBackend<Cpu>);

/// Visible splats of each task, before they are moved together.
template <>
struct ProjectScratch<Cpu> {
  Cpu::Buffer<SplatShape> shapes;
  Cpu::Buffer<float> depths;
  Cpu::Buffer<std::uint32_t> gaussians;
  Cpu::Buffer<std::size_t> counts;

  SWIFTGS_API void reserve(Cpu&, const Reservation& reserved);
  static auto buffers(auto& self) { return std::tie(self.shapes, self.depths, self.gaussians, self.counts); }
};

/// Vector kernel of the projection: a lane a Gaussian.
SWIFTGS_API void project(Cpu& cpu, const FramePlan& plan, ProjectScratch<Cpu>& scratch, Splats<Cpu>& splats);

/// Projection itself has no use for bounds.
template <BoundsPolicy Bounds>
void project(Cpu& cpu, const FramePlan& plan, const Bounds&, ProjectScratch<Cpu>& scratch,
             Splats<Cpu>& splats, Footprints<Cpu>&) {
  project(cpu, plan, scratch, splats);
}

/// Vector kernel of the shading.
SWIFTGS_API Shading<Cpu> shade(Cpu& cpu, const FramePlan& plan, const Splats<Cpu>& splats,
                               Colours<Cpu>& colours);

/// f(view, begin, end) for consecutive splats of one view each, in parallel.
template <class F>
void for_parts_of_views(const Cpu& cpu, const SplatsView& splats, std::size_t grain, const F& f) {
  cpu.for_parts(splats.size(), grain, [&](std::size_t begin, std::size_t end) {
    while (begin < end) {
      const std::uint32_t view = splats.view(begin);
      std::size_t until = splats.of_view ? begin + 1 : end;
      while (until < end && splats.view(until) == view) ++until;
      f(std::size_t(view), begin, until);
      begin = until;
    }
  });
}

/// Footprints of `count` consecutive splats of one view.
template <BoundsPolicy Bounds>
void find_footprints(const Bounds& bounds, const SplatShape* shapes, std::size_t count, TileGrid grid,
                     Footprint* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = find_footprint(bounds, shapes[i], grid);
}
/// Finds the same tiles for a register of splats at a time. Bounds need no such overload.
SWIFTGS_API void find_footprints(const ThreeSigmaSquare& bounds, const SplatShape* shapes, std::size_t count,
                                 TileGrid grid, Footprint* out);
SWIFTGS_API void find_footprints(const OpacityBox& bounds, const SplatShape* shapes, std::size_t count,
                                 TileGrid grid, Footprint* out);
SWIFTGS_API void find_footprints(const Ellipse& bounds, const SplatShape* shapes, std::size_t count,
                                 TileGrid grid, Footprint* out);

/// Footprints in the order in which the splats lie in memory: emission in depth order then jumps among 16
/// bytes a splat.
template <BoundsPolicy Bounds>
void bin(Cpu& cpu, const FramePlan& plan, const Bounds& bounds, Splats<Cpu>& splats,
         Footprints<Cpu>& footprints) {
  footprints.views = plan.views;
  constexpr std::size_t grain = 1024;
  footprints.each.reset(splats.count);
  footprints.count = splats.count, footprints.intersections = 0;
  const SplatShape* const shapes = splats.shapes.data();
  Footprint* const out = footprints.each.data();
  for_parts_of_views(cpu, splats.view(), grain, [&](std::size_t view, std::size_t begin, std::size_t end) {
    find_footprints(bounds, shapes + begin, end - begin, plan.views[view].grid, out + begin);
    std::uint64_t intersections = 0;
    for (std::size_t i = begin; i < end; ++i) intersections += out[i].count;
    std::atomic_ref(footprints.intersections).fetch_add(intersections, std::memory_order_relaxed);
  });
  if (plan.limits.report) *plan.limits.report = await_report(cpu, splats, footprints, plan.limits);
}

/// Tiles of one large splat by bounds of any type: calls f(context, tile) as `for_each_tile` does.
struct LargeTiles {
  using F = void (*)(void* context, std::uint32_t tile);
  const void* bounds;
  void (*traversal)(const void* bounds, const Footprint& footprint, const SplatShape& shape, TileGrid grid,
                    F f, void* context);

  template <BoundsPolicy Bounds>
  explicit LargeTiles(const Bounds& of)
      : bounds(&of),
        traversal([](const void* known, const Footprint& footprint, const SplatShape& shape, TileGrid grid,
                     F f, void* context) {
          for_each_tile(footprint, *static_cast<const Bounds*>(known), shape, grid, Call{f, context});
        }) {}

 private:
  /// No lambda: nvcc would warn that `for_each_tile` is for devices too.
  struct Call {
    F f;
    void* context;
    SWIFTGS_HD void operator()(std::uint32_t tile) const { f(context, tile); }
  };
};

/// Input of emission, whatever the bounds.
struct EmissionJob {
  SplatsView splats;
  Span<const Footprint> footprints;
  std::uint64_t intersections;
  Views views;
  LargeTiles large;
  const std::uint32_t* order;  ///< of the splats; null: index order

  template <BoundsPolicy Bounds>
  EmissionJob(const SortJob& job, const Bounds& bounds, const std::uint32_t* order_)
      : splats(job.splats),
        footprints(job.footprints.each),
        intersections(job.footprints.intersections.most),
        views(job.footprints.views),
        large(bounds),
        order(order_) {
    check_footprints(job);
  }
};

/// Emission in parallel. Throws as the generic one.
SWIFTGS_API Count emit_intersections(Cpu& cpu, const EmissionJob& job,
                                     Pairs<Cpu, std::uint64_t>& intersections);
template <BoundsPolicy Bounds>
Count emit_intersections(Cpu& cpu, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                         IntersectionScratch<Cpu>&, Pairs<Cpu, std::uint64_t>& intersections) {
  return emit_intersections(cpu, EmissionJob(job, bounds, order), intersections);
}

template <>
struct GroupScratch<Cpu> {
  Cpu::Buffer<std::uint32_t> positions;  ///< @shape{parts, tiles}

  SWIFTGS_API void reserve(Cpu& cpu, const Reservation& reserved);
  static auto buffers(auto& self) { return std::tie(self.positions); }
};

/// `group_by_tile` without keys: a counting sort that moves each id straight to its tile.
SWIFTGS_API void group_by_tile(Cpu& cpu, const EmissionJob& job, GroupScratch<Cpu>& scratch,
                               TileLists<Cpu>& lists);
template <BoundsPolicy Bounds>
void group_by_tile(Cpu& cpu, const SortJob& job, const Bounds& bounds, const std::uint32_t* order,
                   GroupScratch<Cpu>& scratch, TileLists<Cpu>& lists) {
  group_by_tile(cpu, EmissionJob(job, bounds, order), scratch, lists);
}

/// Vector kernels of the library's rasterizers: a row of 16 pixels at a time.
SWIFTGS_API void rasterize(Cpu& cpu, PerPixel, const RasterJob& job);
SWIFTGS_API void rasterize(Cpu& cpu, AxisShared<HalfSplit>, const RasterJob& job);
SWIFTGS_API void rasterize(Cpu& cpu, AxisShared<FloatSplit>, const RasterJob& job);
SWIFTGS_API void rasterize(Cpu& cpu, AxisShared<FloatCholesky>, const RasterJob& job);
SWIFTGS_API void rasterize(Cpu& cpu, AxisSharedThreshold<HalfSplit>, const RasterJob& job);
SWIFTGS_API void rasterize(Cpu& cpu, AxisSharedThreshold<FloatSplit>, const RasterJob& job);
SWIFTGS_API void rasterize(Cpu& cpu, AxisSharedThreshold<FloatCholesky>, const RasterJob& job);

}  // namespace swiftgs
