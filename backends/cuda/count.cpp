// SPDX-License-Identifier: Apache-2.0

// Downloads a frame's splats and tile lists and counts its contributing pairs, stopped pixels and hidden
// intersections.
#include <algorithm>
#include <cstddef>
#include <future>
#include <thread>
#include <vector>

#include <swiftgs/cuda/stages.hpp>
#include <swiftgs/drivers/statistics.hpp>
#include <swiftgs/functor/blend.hpp>

namespace swiftgs {
namespace {

template <class T>
std::vector<T> downloaded(const Cuda& cuda, const T* from, std::size_t size) {
  std::vector<T> to(size);
  if (size != 0) cuda.download(Span<const T>{from, size}, to.data());
  return to;
}
template <class T>
Span<const T> span_of(const std::vector<T>& values) {
  return {values.data(), values.size()};
}

/// A job in the host's memory, whose views have no plane but their occluders.
class HostJob {
 public:
  HostJob(const Cuda& cuda, const RasterJob& from)
      : shapes_(downloaded(cuda, from.splats.shapes.data, from.splats.size())),
        depths_(downloaded(cuda, from.splats.depths.data, from.splats.size())),
        colours_(downloaded(cuda, from.colours.each.data, from.splats.size())),
        ids_(downloaded(cuda, from.lists.ids.data, from.lists.ids.size)),
        ranges_(downloaded(cuda, from.lists.ranges.data, from.lists.ranges.size)),
        views_(from.views.begin(), from.views.end()),
        blocks_(raster_blocks_of(from)),
        counts_(blocks_.size()) {
    bool along_ray = false;
    for (View& view : views_) {
      along_ray = along_ray || hides_along_ray(view);
      keep_occluder(cuda, view.frame);
    }
    if (along_ray)
      rows_ = downloaded(cuda, from.attributes.first_row, from.splats.size() * from.attributes.first_stride);
    job_.splats.shapes = span_of(shapes_), job_.splats.depths = span_of(depths_);
    job_.colours.each = span_of(colours_);
    job_.lists = {span_of(ids_), span_of(ranges_)};
    job_.views = Views(span_of(views_));
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
  void keep_occluder(const Cuda& cuda, FrameView& frame) {
    const FrameView from = frame;
    frame = {.width = from.width, .height = from.height};
    if (!from.occluder.data) return;
    const auto width = std::size_t(from.width);
    std::vector<float>& depths = occluders_.emplace_back(width * std::size_t(from.height));
    for (std::size_t y = 0; y < std::size_t(from.height); ++y)
      cuda.download(Span<const float>{from.occluder.row(y), width}, depths.data() + y * width);
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

}  // namespace

FrameCounted count_frame(const Cuda& cuda, const RasterJob& from, CountRasterBlock count) {
  const HostJob on_host(cuda, from);
  const std::size_t blocks = on_host.blocks().size(),
                    threads = std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::future<void>> parts;
  for (std::size_t first = 0; first < threads; ++first)
    parts.push_back(std::async(std::launch::async, [&, first] {
      for (std::size_t block = first; block < blocks; block += threads)
        count(on_host.job(), on_host.blocks(), block);
    }));
  for (std::future<void>& part : parts) part.get();
  return {on_host.sum(), count_hidden(on_host.job())};
}

}  // namespace swiftgs
