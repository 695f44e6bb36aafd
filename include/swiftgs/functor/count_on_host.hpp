// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Counts what a device's frame took by the rasterizer of hosts.

#include <cstddef>
#include <cstdint>
#include <vector>

#include <swiftgs/drivers/statistics.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/functor/blend.hpp>
#include <swiftgs/tools/parallel.hpp>

namespace swiftgs {

namespace detail {
template <class B, class T>
std::vector<T> downloaded(const B& b, const T* from, std::size_t size) {
  std::vector<T> to(size);
  if (size != 0) b.download(Span<const T>{from, size}, to.data());
  return to;
}
template <class T>
Span<const T> span_of(const std::vector<T>& values) {
  return {values.data(), values.size()};
}
}  // namespace detail

/// A job in the host's memory, whose views have no plane but their occluders.
template <class B>
class HostJob {
 public:
  HostJob(const B& b, const RasterJob& from)
      : shapes_(detail::downloaded(b, from.splats.shapes.data, from.splats.size())),
        depths_(detail::downloaded(b, from.splats.depths.data, from.splats.size())),
        colours_(detail::downloaded(b, from.colours.each.data, from.splats.size())),
        ids_(detail::downloaded(b, from.lists.ids.data, from.lists.ids.size)),
        ranges_(detail::downloaded(b, from.lists.ranges.data, from.lists.ranges.size)),
        views_(from.views.begin(), from.views.end()),
        blocks_(raster_blocks_of(from)),
        counts_(blocks_.size()) {
    bool along_ray = false;
    for (View& view : views_) {
      along_ray = along_ray || hides_along_ray(view);
      keep_occluder(b, view.frame);
    }
    if (along_ray)
      rows_ =
          detail::downloaded(b, from.attributes.first_row, from.splats.size() * from.attributes.first_stride);
    job_.splats.shapes = detail::span_of(shapes_), job_.splats.depths = detail::span_of(depths_);
    job_.colours.each = detail::span_of(colours_);
    job_.lists = {detail::span_of(ids_), detail::span_of(ranges_)};
    job_.views = Views(detail::span_of(views_));
    job_.counts = counts_.data();
    job_.attributes = {.first_row = rows_.data(), .first_stride = from.attributes.first_stride};
  }
  HostJob(const HostJob&) = delete;
  HostJob& operator=(const HostJob&) = delete;

  const RasterJob& job() const { return job_; }
  const RasterBlocks& blocks() const { return blocks_; }
  RasterCounts sum() const {
    RasterCounts all;
    for (const RasterCounts& block : counts_) all += block;
    return all;
  }

 private:
  void keep_occluder(const B& b, FrameView& frame) {
    const FrameView from = frame;
    frame = {.width = from.width, .height = from.height};
    if (!from.occluder.data) return;
    const auto width = std::size_t(from.width);
    std::vector<float>& depths = occluders_.emplace_back(width * std::size_t(from.height));
    for (std::size_t y = 0; y < std::size_t(from.height); ++y)
      b.download(Span<const float>{from.occluder.row(y), width}, depths.data() + y * width);
    frame.occluder = {depths.data(), std::ptrdiff_t(width * sizeof(float))};
    frame.stored_depth = from.stored_depth;
  }

  std::vector<SplatShape> shapes_;
  std::vector<float> depths_;
  std::vector<SplatColour> colours_;
  std::vector<std::uint32_t> ids_;
  std::vector<TileRange> ranges_;
  std::vector<View> views_;
  std::vector<std::vector<float>> occluders_;
  std::vector<AttributeRow> rows_;
  RasterBlocks blocks_;
  std::vector<RasterCounts> counts_;
  RasterJob job_;
};

/// Downloads what `from` was rasterized from on device `b`, and counts contributing pairs, stopped pixels and
/// hidden intersections on all cores of the host. Waits.
template <class B>
FrameCounted count_on_host(const B& b, const RasterJob& from, CountRasterBlock count) {
  const HostJob<B> on_host(b, from);
  HostThreads().for_each(on_host.blocks().size(),
                         [&](std::size_t block) { count(on_host.job(), on_host.blocks(), block); });
  return {on_host.sum(), count_hidden(on_host.job())};
}

}  // namespace swiftgs
