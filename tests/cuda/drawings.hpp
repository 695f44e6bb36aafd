// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The same splats and lists, drawn by the serial backend and by the device.

#include <vector>

#include "cuda/device.hpp"
#include "policies/double_drawing.hpp"
#include "policies/rasterizers.hpp"

namespace swiftgs::test {

/// A frame of `FrameView`'s planes in the memory of a device.
struct DeviceFrame {
  DeviceFrame(int width_, int height_, PixelFormat format_ = PixelFormat::rgb_float, std::size_t padding_ = 0)
      : width(width_), height(height_), format(format_), padding(padding_) {
    for (DeviceBuffer<unsigned char>* plane : {&colour, &alpha, &depth})
      copy_to_device({filler().data(), filler().size()}, *plane);
  }

  /// Distance between rows of pixels of so many bytes.
  std::size_t pitch(std::size_t pixel) const { return pixel * std::size_t(width) + padding; }
  FrameView view() {
    return {.width = width,
            .height = height,
            .colour = {colour.data(), pitch(bytes_per_pixel(format))},
            .format = format,
            .alpha = {reinterpret_cast<float*>(alpha.data()), pitch(sizeof(float))},
            .depth = {reinterpret_cast<float*>(depth.data()), pitch(sizeof(float))}};
  }
  /// Rows without what lies between them, as `T`.
  template <class T = float>
  std::vector<T> pixels(const Cuda& cuda, const DeviceBuffer<unsigned char>& plane, std::size_t pixel) const {
    const std::vector<unsigned char> bytes = to_host(cuda, plane.span());
    std::vector<T> out(pixel / sizeof(T) * std::size_t(width) * std::size_t(height));
    for (std::size_t y = 0; y < std::size_t(height); ++y)
      std::memcpy(out.data() + y * std::size_t(width) * (pixel / sizeof(T)), bytes.data() + y * pitch(pixel),
                  pixel * std::size_t(width));
    return out;
  }
  /// Whether nothing was written behind the rows of a plane.
  bool kept_to_its_rows(const Cuda& cuda, const DeviceBuffer<unsigned char>& plane, std::size_t pixel) const {
    const std::vector<unsigned char> bytes = to_host(cuda, plane.span());
    for (std::size_t i = 0; i < bytes.size(); ++i)
      if ((i % pitch(pixel) >= pixel * std::size_t(width) || i >= pitch(pixel) * std::size_t(height)) &&
          bytes[i] != nobodys)
        return false;
    return true;
  }

  static constexpr unsigned char nobodys = 0xa5;
  int width, height;
  PixelFormat format;
  std::size_t padding;
  DeviceBuffer<unsigned char> colour, alpha, depth;

 private:
  std::vector<unsigned char> filler() const {
    return std::vector<unsigned char>((pitch(16) + 16) * std::size_t(height), nobodys);
  }
};

/// Splats with the lists that the serial backend makes of them, and what they are drawn with.
struct Picture {
  Picture(SplatSet set, int width_, int height_, const DrawSettings& settings_ = {})
      : splats(std::move(set)), width(width_), height(height_), settings(settings_) {
    use_bounds(OpacityBox());
  }

  template <class Bounds>
  void use_bounds(Bounds) {
    Serial serial;
    lists = host_lists(serial, build_lists<StandardSort, Bounds>(serial, splats.job(width, height)));
  }
  RasterJob job(const SplatsView& of, const ColoursView& colours, const TileListsView& listed,
                const FrameView& frame, TileCounts* counts) const {
    return {of,    colours, listed, TileGrid::covering(width, height), settings.rules, settings.background,
            frame, counts};
  }

  SplatSet splats;
  int width, height;
  DrawSettings settings;
  HostLists lists;
  std::vector<float> occluder;  ///< @shape{height, width} or empty
};

template <class Raster>
Drawing draw_on_host(const Picture& picture) {
  Serial serial;
  Drawing out;
  FrameView view = prepare(out.frame, picture.width, picture.height, picture.settings.outputs);
  if (!picture.occluder.empty())
    view.occluder = {picture.occluder.data(), sizeof(float) * std::size_t(view.width)};
  std::vector<TileCounts> counts(picture.lists.ranges.size());
  rasterize(serial, Raster{},
            picture.job(picture.splats.view(), picture.splats.colours_view(), picture.lists.view(), view,
                        counts.data()));
  for (const TileCounts& tile : counts) out.counts += tile;
  return out;
}

/// A picture in the memory of a device.
struct DevicePicture {
  explicit DevicePicture(const Picture& of)
      : picture(of),
        splats(of.splats),
        ids(to_device(of.lists.ids)),
        ranges(to_device(of.lists.ranges)),
        occluder(to_device(of.occluder)),
        counts(to_device(std::vector<TileCounts>(of.lists.ranges.size()))) {}

  /// The job that draws it into `frame`, before the surface that hides it.
  RasterJob job(FrameView frame, bool count) {
    if (!picture.occluder.empty())
      frame.occluder = {occluder.data(), sizeof(float) * std::size_t(picture.width)};
    return picture.job(splats.view(), splats.colours_view(),
                       {std::as_const(ids).span(), std::as_const(ranges).span()}, frame,
                       count ? counts.data() : nullptr);
  }

  const Picture& picture;
  DeviceSplats splats;
  DeviceBuffer<std::uint32_t> ids;
  DeviceBuffer<TileRange> ranges;
  DeviceBuffer<float> occluder;
  DeviceBuffer<TileCounts> counts;
};

/// `lean`: by the kernels that know neither depth nor counts.
template <class Raster>
Drawing draw_on_device(Cuda& cuda, const Picture& picture, bool lean = false) {
  DevicePicture device(picture);
  DeviceFrame frame(picture.width, picture.height);
  FrameView view = frame.view();
  if (lean) view.depth = {};
  rasterize(cuda, Raster{}, device.job(view, !lean));
  Drawing out;
  out.frame.width = picture.width, out.frame.height = picture.height;
  out.frame.colour = frame.pixels(cuda, frame.colour, 12);
  out.frame.alpha = frame.pixels(cuda, frame.alpha, 4);
  if (!lean) {
    out.frame.depth = frame.pixels(cuda, frame.depth, 4);
    for (const TileCounts& tile : to_host(cuda, std::as_const(device.counts).span())) out.counts += tile;
  }
  return out;
}

}  // namespace swiftgs::test
