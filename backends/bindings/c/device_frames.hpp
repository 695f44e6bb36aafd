// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdlib>
#include <utility>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/frame/views.hpp>

#include "device.hpp"

namespace swiftgs::c {

/// A plane of the host and its copy on a device, which is dense and runs in the same direction.
struct CopiedPlane {
  std::byte *host = nullptr, *device = nullptr;  ///< lowest address of either
  std::size_t row, height, pitch;  ///< bytes of a row, rows, bytes from a row of the host to the next
  bool up;

  CopiedPlane(const void* data, std::ptrdiff_t from_row_to_row, std::size_t row_bytes, int rows)
      : row(row_bytes),
        height(std::size_t(rows)),
        pitch(std::size_t(std::abs(from_row_to_row))),
        up(from_row_to_row < 0) {
    const auto* const top_of_host = static_cast<const std::byte*>(data);
    host =
        const_cast<std::byte*>(up ? top_of_host + std::ptrdiff_t(height - 1) * from_row_to_row : top_of_host);
  }

  std::size_t bytes() const { return (row * height + 255) / 256 * 256; }
  /// The top row of the image on the device, and the way down.
  void* top() const { return up ? device + (height - 1) * row : device; }
  std::ptrdiff_t way_down() const { return up ? -std::ptrdiff_t(row) : std::ptrdiff_t(row); }
};

/// `HostFrames` through dense planes in a device's memory. `Copies` has `Buffer`, and `upload` and `download`
/// of a `CopiedPlane` in the order of the renderer's work.
template <class Copies>
class DeviceFrames final : public HostFrames {
 public:
  explicit DeviceFrames(const BackendOptions& options) : copies_(options) {
    if (options.memory) memory_.use(*options.memory);
  }

  void render_into(AnyRenderer& renderer, Span<const View> views, Measures measures) override {
    for (const View& view : views) validate(view);  // before a plane is taken at its word
    renderer.wait();                                // nothing of an earlier frame reads the memory
    planes_.clear(), views_.assign(views.begin(), views.end());
    std::size_t bytes = 0;
    each_plane([&](auto& plane, std::size_t pixel, const FrameView& frame, bool, bool) {
      planes_.emplace_back(plane.data, plane.pitch, pixel * std::size_t(frame.width), frame.height);
      bytes += planes_.back().bytes();
    });
    memory_.reset(bytes);

    std::size_t next = 0, offset = 0;
    bool uploaded = false;
    each_plane([&](auto& plane, std::size_t, const FrameView&, bool is_read, bool) {
      CopiedPlane& copied = planes_[next++];
      copied.device = memory_.data() + offset;
      offset += copied.bytes();
      if (is_read) copies_.upload(copied), uploaded = true;
      plane.data = static_cast<decltype(plane.data)>(copied.top()), plane.pitch = copied.way_down();
    });
    if (uploaded) renderer.wait();  // if the frame throws, nothing reads the caller's memory any more
    renderer.render_into({views_.data(), views_.size()}, measures);
    next = 0;
    each_plane([&](auto&, std::size_t, const FrameView&, bool, bool is_written) {
      if (is_written) copies_.download(planes_[next]);
      ++next;
    });
    renderer.wait();
  }
  std::size_t bytes() const override { return memory_.bytes(); }
  void trim() override { memory_.trim(); }

 private:
  /// f(plane, bytes of a pixel, its frame, whether the frame reads it, whether it writes it) for every plane.
  template <class F>
  void each_plane(const F& f) {
    for (View& view : views_) {
      FrameView& frame = view.frame;
      for_each_plane(
          [&](std::size_t, auto& plane, std::size_t pixel, bool is_read) {
            if (plane.data) f(plane, pixel, frame, is_read, true);
          },
          frame, frame.pixel_bytes(), PerPlane<bool>{.colour = frame.over});
      if (frame.occluder.data) f(frame.occluder, sizeof(float), frame, true, false);
    }
  }

  Copies copies_;
  typename Copies::template Buffer<std::byte> memory_;
  std::vector<CopiedPlane> planes_;
  std::vector<View> views_;
};

}  // namespace swiftgs::c
