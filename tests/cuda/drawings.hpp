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
    const std::ptrdiff_t colour_pitch = std::ptrdiff_t(pitch(bytes_per_pixel(format))),
                         float_pitch = std::ptrdiff_t(pitch(sizeof(float)));
    return {.width = width,
            .height = height,
            .colour = {colour.data(), colour_pitch},
            .format = format,
            .alpha = {reinterpret_cast<float*>(alpha.data()), float_pitch},
            .depth = {reinterpret_cast<float*>(depth.data()), float_pitch}};
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
    lists =
        host_lists(serial, build_lists<StandardSort, Bounds>(serial, splats.job(width, height, tile_side)));
  }
  View view(const FrameView& frame) const {
    return {.rules = settings.rules,
            .background = settings.background,
            .grid = TileGrid::covering(width, height, tile_side),
            .frame = frame};
  }

  SplatSet splats;
  int width, height;
  DrawSettings settings;
  int tile_side = default_tile_side;
  HostLists lists;
  std::vector<float> occluder;  ///< @shape{height, width} or empty
};

template <class Raster>
Drawing draw_on_host(const Picture& picture) {
  Serial serial;
  Drawing out;
  View view = picture.view(prepare(out.frame, picture.width, picture.height, picture.settings.outputs));
  if (!picture.occluder.empty())
    view.frame.occluder = {picture.occluder.data(), std::ptrdiff_t(sizeof(float)) * picture.width};
  std::vector<SquareCounts> counts(Squares(tiles_of_frame(view)).size());
  rasterize(serial, Raster{},
            RasterJob{picture.splats.view(),
                      picture.splats.colours_view(),
                      picture.lists.view(),
                      {&view, 1},
                      counts.data()});
  for (const SquareCounts& tile : counts) out.counts += tile;
  return out;
}

/// A picture in the memory of a device.
struct DevicePicture {
  explicit DevicePicture(const Picture& of)
      : picture(of),
        splats(Cuda(), of.splats),
        ids(to_device(of.lists.ids)),
        ranges(to_device(of.lists.ranges)),
        occluder(to_device(of.occluder)),
        counts(to_device(std::vector<SquareCounts>(
            Squares(tiles_of_frame(of.view({.width = of.width, .height = of.height}))).size()))) {}

  /// The job that draws it into `frame`, before the surface that hides it. Holds until the next.
  RasterJob job(FrameView frame, bool count) {
    if (!picture.occluder.empty())
      frame.occluder = {occluder.data(), std::ptrdiff_t(sizeof(float)) * picture.width};
    view = picture.view(frame);
    return {splats.view(),
            splats.colours_view(),
            {std::as_const(ids).span(), std::as_const(ranges).span()},
            {&view, 1},
            count ? counts.data() : nullptr};
  }

  const Picture& picture;
  SplatsOn<Cuda> splats;
  DeviceBuffer<std::uint32_t> ids;
  DeviceBuffer<TileRange> ranges;
  DeviceBuffer<float> occluder;
  DeviceBuffer<SquareCounts> counts;
  View view;
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
    for (const SquareCounts& tile : to_host(cuda, std::as_const(device.counts).span())) out.counts += tile;
  }
  return out;
}

}  // namespace swiftgs::test
