// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Splats in, tile lists out: what the tests of sorts and bounds have in common.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <type_traits>
#include <vector>

#include <swiftgs/bounds/opacity_box.hpp>
#include <swiftgs/frame/sort.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/functor/bounds_stages.hpp>

#include "policies/random_splats.hpp"
#include "support/one_view.hpp"

namespace swiftgs::test {

/// The elements of a vector.
template <class T>
Span<T> span_of(std::vector<T>& elements) {
  return {elements.data(), elements.size()};
}
template <class T>
Span<const T> span_of(const std::vector<T>& elements) {
  return {elements.data(), elements.size()};
}

/// How values of the host get into memory of backend `B`, which a host reaches here. Other backends
/// specialise this.
template <class B>
struct CopyToBackend {
  template <class T>
  static void copy(Span<const T> from, T* to) {
    std::copy(from.begin(), from.end(), to);
  }
};

/// Copies to memory of a backend; complete when it returns.
template <class B, class T>
typename B::template Buffer<T> to_backend(const B&, const std::vector<T>& from) {
  typename B::template Buffer<T> to;
  to.reset(from.size());
  if (!from.empty()) CopyToBackend<B>::copy(Span<const T>{from.data(), from.size()}, to.data());
  return to;
}

/// Copies to the host after all work of `backend`.
template <class B, class T>
std::vector<T> to_host(const B& backend, Span<const T> from) {
  std::vector<T> to(from.size);
  backend.download(from, to.data());
  return to;
}

/// The same of `each` values in every row.
template <class B, class T>
std::vector<std::remove_const_t<T>> to_host(const B& backend, const StridedSpan<T>& rows,
                                            std::size_t each = 1) {
  std::vector<std::remove_const_t<T>> to(rows.size * each);
  if (to.empty()) return to;
  const std::size_t stride = rows.stride / sizeof(float), used = each * sizeof(T) / sizeof(float);
  const std::vector<float> all = to_host(
      backend, Span<const float>{reinterpret_cast<const float*>(rows.data), (rows.size - 1) * stride + used});
  for (std::size_t i = 0; i < rows.size; ++i)
    std::memcpy(static_cast<void*>(&to[each * i]), &all[stride * i], each * sizeof(T));
  return to;
}

template <class B>
std::vector<float> to_host(const B& backend, const HarmonicRows& floats, std::size_t each) {
  return to_host(backend, floats.floats(), each);
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// Splats in a backend's memory that are to be sorted for an image.
struct SortInput {
  SplatsView splats;
  TileGrid grid;
  FrameKey key;
};

/// Copies splats of one view within a host's memory. Other backends specialise this.
template <class B>
struct CopySplats {
  static void copy(const SplatsView& from, Splats<B>& to) {
    to.resize(from.size(), 1);
    std::copy(from.shapes.begin(), from.shapes.end(), to.shapes.data());
    std::copy(from.depths.begin(), from.depths.end(), to.depths.data());
    std::copy(from.gaussians.begin(), from.gaussians.end(), to.gaussians.data());
    to.count = from.size();
  }
};

/// Splats with their footprints: what is sorted.
template <class B, class Bounds>
struct Binned {
  Binned(B& backend, const SortInput& input, const Bounds& bounds)
      : key(input.key),
        view(view_without_camera(int(input.key.width), int(input.key.height), input.grid.side)) {
    CopySplats<B>::copy(input.splats, splats);
    bin(backend, plan_without_scene({&view, 1}), bounds, splats, footprints);
  }
  Binned(const Binned&) = delete;
  Binned& operator=(const Binned&) = delete;

  SortJob job() const { return {splats.view(), footprints.view(), key}; }

  Splats<B> splats;
  Footprints<B> footprints;
  FrameKey key;
  View view;  ///< the footprints refer to it
};

/// Splats on the host, and what sorts them for an image.
struct SplatSet {
  std::vector<SplatShape> shapes;
  std::vector<float> depths;
  std::vector<std::uint32_t> gaussians;
  std::vector<SplatColour> colours;

  void add(const SplatShape& shape, float depth, vec3 rgb = vec3(1)) {
    gaussians.push_back(std::uint32_t(shapes.size()));
    shapes.push_back(shape), depths.push_back(depth);
    colours.push_back({rgb, depth});
  }
  SplatsView view() const {
    return {
        {shapes.data(), shapes.size()}, {depths.data(), depths.size()}, {gaussians.data(), gaussians.size()}};
  }
  ColoursView colours_view() const { return {{colours.data(), colours.size()}}; }
  SortInput job(int width, int height, int tile_side = default_tile_side) const {
    return {view(), TileGrid::covering(width, height, tile_side), {identity, shapes.size(), width, height}};
  }

  std::uint64_t identity = new_scene_identity();  ///< as if the splats were a scene's
};

/// Splats of the host in memory of a backend.
template <class B>
class SplatsOn {
 public:
  SplatsOn(const B& backend, const SplatSet& set)
      : identity_(set.identity),
        shapes_(to_backend(backend, set.shapes)),
        depths_(to_backend(backend, set.depths)),
        gaussians_(to_backend(backend, set.gaussians)),
        colours_(to_backend(backend, set.colours)) {}

  SplatsView view() const { return {shapes_.span(), depths_.span(), gaussians_.span()}; }
  ColoursView colours_view() const { return {colours_.span()}; }
  SortInput job(int width, int height, int tile_side = default_tile_side) const {
    return {view(), TileGrid::covering(width, height, tile_side), {identity_, shapes_.size(), width, height}};
  }

 private:
  std::uint64_t identity_;
  typename B::template Buffer<SplatShape> shapes_;
  typename B::template Buffer<float> depths_;
  typename B::template Buffer<std::uint32_t> gaussians_;
  typename B::template Buffer<SplatColour> colours_;
};

/// Splats of a backend on the host, without colours where there are none.
template <class B>
SplatSet to_host(const B& backend, const SplatsView& splats, const ColoursView& colours = {}) {
  return {to_host(backend, splats.shapes), to_host(backend, splats.depths),
          to_host(backend, splats.gaussians), to_host(backend, colours.each)};
}

/// Random splats for a width x height image; few depths, so that many are equal.
inline SplatSet random_splats(std::size_t count, int width, int height, std::uint64_t seed) {
  Random random(seed);
  SplatSet set;
  for (std::size_t i = 0; i < count; ++i) {
    const SplatShape shape =
        i % 10 == 0 ? random_splat(random, width, height) : usual_splat(random, width, height);
    set.add(shape, i % 3 == 0 ? float(1 + random.bits() % 4) : random.f(0.01, 100));
  }
  return set;
}

/// Tile lists as plain vectors, one a tile.
using Lists = std::vector<std::vector<std::uint32_t>>;

inline Lists to_vectors(const TileListsView& lists) {
  Lists out(lists.ranges.size);
  for (std::size_t tile = 0; tile < out.size(); ++tile)
    for (std::uint32_t at = lists.ranges[tile].begin; at < lists.ranges[tile].end; ++at)
      out[tile].push_back(lists.ids[at]);
  return out;
}

/// Tile lists as arrays of the host.
struct HostLists {
  std::vector<std::uint32_t> ids;
  std::vector<TileRange> ranges;

  bool operator==(const HostLists& o) const { return same_bits(ids, o.ids) && same_bits(ranges, o.ranges); }
  TileListsView view() const { return {{ids.data(), ids.size()}, {ranges.data(), ranges.size()}}; }
};

template <class B>
HostLists host_lists(const B& backend, const TileLists<B>& lists) {
  return {to_host(backend, lists.view().ids), to_host(backend, lists.view().ranges)};
}

/// Every tile against every splat: in the list where the bounds' row has the tile, ordered by depth, then
/// index.
template <class Bounds>
Lists brute_force_lists(const SortInput& job) {
  Lists lists(job.grid.size());
  const Bounds bounds;
  for (int row = job.grid.rows.begin; row < job.grid.rows.end; ++row)
    for (int column = job.grid.columns.begin; column < job.grid.columns.end; ++column) {
      std::vector<std::uint32_t>& list = lists[job.grid.number(column, row)];
      for (std::uint32_t id = 0; id < job.splats.size(); ++id) {
        const auto tiles = bounds.tiles(job.splats.shapes[id], job.grid);
        const TileRect& rect = tiles.rect;
        if (row < rect.rows.begin || row >= rect.rows.end || rect.columns.size() == 0) continue;
        const TileRun run = detail::row_within(tiles, row);
        if (column >= run.begin && column < run.end) list.push_back(id);
      }
      std::stable_sort(list.begin(), list.end(), [&](std::uint32_t a, std::uint32_t b) {
        return job.splats.depths[a] < job.splats.depths[b];
      });
    }
  return lists;
}

/// Bounds of a program: the even rows of the box.
struct EvenRows {
  static constexpr std::string_view name = "even-rows";
  static constexpr bool conservative = false;
  struct Tiles {
    TileRect rect;
    SWIFTGS_HD TileRun row(int row) const { return row % 2 ? TileRun{} : rect.columns; }
  };
  SWIFTGS_HD Tiles tiles(const SplatShape& shape, TileGrid grid) const {
    return {opacity_box(shape, EllipseExtent(shape), grid.side).within(grid)};
  }
};

/// Sorts `job` in memory of earlier frames.
template <class Bounds, class B, class Sort, class Scratch>
void build_again(B& backend, Sort& sort, const SortInput& job, Scratch& scratch, TileLists<B>& lists) {
  const Binned<B, Bounds> binned(backend, job, Bounds{});
  sort.build(backend, binned.job(), Bounds{}, scratch, lists);
}

/// Whether each splat is listed so many times, and no list names a splat twice or one that there is not.
inline bool lists_each(const Lists& lists, std::size_t splats, std::size_t times) {
  std::vector<std::size_t> seen(splats);
  for (std::vector<std::uint32_t> list : lists) {
    std::sort(list.begin(), list.end());
    if (std::adjacent_find(list.begin(), list.end()) != list.end()) return false;
    if (!list.empty() && list.back() >= splats) return false;
    for (const std::uint32_t id : list) ++seen[id];
  }
  return std::all_of(seen.begin(), seen.end(), [&](std::size_t count) { return count == times; });
}

/// What `Sort` makes of `job` on `backend`.
template <class Sort, class Bounds, class B>
TileLists<B> build_lists(B& backend, const SortInput& job, Sort sort = Sort()) {
  typename Sort::template Scratch<B> scratch;
  TileLists<B> lists;
  build_again<Bounds>(backend, sort, job, scratch, lists);
  return lists;
}

}  // namespace swiftgs::test
