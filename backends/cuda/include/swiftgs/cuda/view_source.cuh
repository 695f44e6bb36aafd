// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs::kernels {

/// The only view of a frame, as an argument of a kernel. Reading it costs neither a load nor a register.
/// Kernels are compiled for `OneView` and for `StoredViews`. Measured on an H200: with a stored view
/// projection takes 5 to 8 % longer, and rasterizing as long.
struct OneView {
  static constexpr bool only = true;
  View view;

  __device__ const View& operator[](std::uint32_t) const { return view; }
  __device__ std::uint32_t size() const { return 1; }

  /// Where the raster block in this column and row of a frame lies.
  __device__ RasterBlockOrigin origin(const RasterBlocks&, std::uint32_t column, std::uint32_t row) const {
    return {0, int(column) * raster_block_side, int(row) * raster_block_side};
  }
};

/// Views in device memory.
struct StoredViews {
  static constexpr bool only = false;
  const View* views;
  std::uint32_t count;

  __device__ const View& operator[](std::uint32_t view) const { return views[view]; }
  __device__ std::uint32_t size() const { return count; }
  __device__ RasterBlockOrigin origin(const RasterBlocks& raster_blocks, std::uint32_t column,
                                      std::uint32_t row) const {
    return raster_blocks.origin(views, count, column, row);
  }
};

/// f(source) with the views as kernels take them.
template <class F>
void with_views(const Views& views, const F& f) {
  if (views.stored)
    f(StoredViews{views.stored, std::uint32_t(views.size())});
  else
    f(OneView{views.each[0]});
}

/// f(views, scenes) as kernels take them.
template <class F>
void with_views_and_scenes(const Views& views, const StoredScenes& scenes, const F& f) {
  with_views(views, [&](const auto& source) {
    if (scenes.is_on_device())
      f(source, SeveralScenes{scenes.reachable(), std::uint32_t(scenes.size())});
    else
      f(source, OneScene{scenes.each()[0].scene});
  });
}

}  // namespace swiftgs::kernels
