// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames whose rows go down or up in memory.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <tuple>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/frame.hpp>

#include "policies/images.hpp"

namespace swiftgs::test {

/// Memory of a frame with an image to be drawn over, alpha, depth, an occluder and the planes that are asked
/// for besides. It holds more than their rows: bytes behind each row, a row before the first and one behind
/// the last, which belong to nobody.
class PlanesMemory {
 public:
  static constexpr unsigned char nobodys = Image::nobodys;
  /// Number of planes: those of the table, with the occluder among them.
  static constexpr std::size_t planes = 1 + std::tuple_size_v<decltype(plane_table.buffers(plane_table))>;
  static constexpr std::size_t occluder = 3;

  /// Rows of all planes go down. Behind each are bytes `beside` it, a multiple of 8.
  PlanesMemory(int width, int height, PixelFormat format, std::size_t beside = 24,
               const Outputs& further = {})
      : width_(width), height_(height), features_(further.features), beside_(beside), format_(format) {
    Outputs outputs = further;
    outputs.alpha = outputs.depth = true;
    for_each_place([&](std::size_t plane, std::size_t channels,
                       bool wanted) { pixel_[plane] = wanted ? channels * sizeof(float) : 0; },
                   outputs);
    pixel_[0] = bytes_per_pixel(format), pixel_[occluder] = sizeof(float);
    for (std::size_t plane = 0; plane < planes; ++plane)
      if (has(plane)) bytes[plane].assign(row(plane) * (std::size_t(height) + 2), nobodys);
    const float depths[] = {3, std::numeric_limits<float>::infinity(), 1.5f, 0, 7, 4, 5};
    const Image below = pattern(width, height, format);
    for (std::size_t y = 0; y < std::size_t(height); ++y) {
      std::memcpy(&bytes[0][(y + 1) * row(0)], &below.bytes[y * below.pitch], pixel_[0] * std::size_t(width));
      for (std::size_t x = 0; x < std::size_t(width); ++x)
        std::memcpy(&bytes[3][(y + 1) * row(3) + x * sizeof(float)], &depths[(x + y * y) % std::size(depths)],
                    sizeof(float));
    }
  }

  /// Lets the rows of a plane go the other way.
  void turn(std::size_t plane) {
    if (!has(plane)) return;
    upward_[plane] = !upward_[plane];
    const std::vector<unsigned char> from = bytes[plane];
    const std::ptrdiff_t length = std::ptrdiff_t(row(plane));
    for (auto at = from.begin(); at != from.end(); at += length)
      std::copy(at, at + length, bytes[plane].end() - (at - from.begin()) - length);
  }

  /// The frame in copies of `bytes`, which begin at `memory`.
  FrameView frame(const std::array<unsigned char*, planes>& memory) const {
    FrameView out{.width = width_, .height = height_, .format = format_, .feature_channels = features_};
    const auto place = [&]<class T>(std::size_t plane, Plane<T>& to) {
      if (!has(plane)) return;
      unsigned char* const top = memory[plane] + (upward_[plane] ? std::size_t(height_) : 1) * row(plane);
      to = {reinterpret_cast<T*>(top),
            upward_[plane] ? -std::ptrdiff_t(row(plane)) : std::ptrdiff_t(row(plane))};
    };
    for_each_place([&](std::size_t plane, std::size_t, auto& to) { place(plane, to); }, out);
    place(occluder, out.occluder);
    return out;
  }
  bool has(std::size_t plane) const { return pixel_[plane] > 0; }

  /// The rows of a plane of floats that go down, one behind the other.
  std::vector<float> rows(std::size_t plane) const {
    const std::size_t used = pixel_[plane] * std::size_t(width_);
    std::vector<float> out(used / sizeof(float) * std::size_t(height_));
    for (std::size_t y = 0; y < std::size_t(height_); ++y)
      std::memcpy(out.data() + y * used / sizeof(float), &bytes[plane][(y + 1) * row(plane)], used);
    return out;
  }

  /// Whether nothing was written but the rows.
  bool kept_to_its_rows() const {
    for (std::size_t plane = 0; plane < planes; ++plane)
      for (std::size_t i = 0; i < bytes[plane].size(); ++i) {
        const std::size_t y = i / row(plane), at = i % row(plane);
        const bool inside = y >= 1 && y <= std::size_t(height_) && at < pixel_[plane] * std::size_t(width_);
        if (!inside && bytes[plane][i] != nobodys) return false;
      }
    return true;
  }

  std::array<std::vector<unsigned char>, planes> bytes;  ///< of the planes in the order of `frame`

 private:
  /// f(index of the plane here, its channels, of.plane) for each plane of the table.
  template <class F>
  static void for_each_place(const F& f, auto& of) {
    std::size_t plane = 0;
    for_each_plane(
        [&](std::size_t channels, auto& of_plane) {
          if (plane == occluder) ++plane;
          f(plane++, channels, of_plane);
        },
        of);
  }
  /// Bytes of a row and of those behind it.
  std::size_t row(std::size_t plane) const { return pixel_[plane] * std::size_t(width_) + beside_; }

  int width_, height_, features_;
  std::size_t beside_;
  PixelFormat format_;
  std::array<std::size_t, planes> pixel_;  ///< @units{bytes}
  std::array<bool, planes> upward_{};
};

/// Checks that planes hold the same rows whichever way they go, each plane turned alone and all together.
/// `draw(memory, over)` draws a frame of so many pixels into `memory`, which has `further` planes.
template <class Draw>
void check_directions(int width, int height, const Draw& draw, const Outputs& further = {}) {
  for (const PixelFormat format : pixel_formats)
    for (const bool over : {false, true}) {
      CAPTURE(int(format));
      CAPTURE(over);
      const PlanesMemory before(width, height, format, 24, further);
      PlanesMemory down = before;
      draw(down, over);
      CHECK(down.kept_to_its_rows());
      for (std::size_t plane = 0; plane < PlanesMemory::planes; ++plane)
        CHECK((down.bytes[plane] == before.bytes[plane]) ==
              (plane == PlanesMemory::occluder || !before.has(plane)));
      std::vector<unsigned> turns{(1u << PlanesMemory::planes) - 1};
      for (std::size_t plane = 0; plane < PlanesMemory::planes; ++plane)
        if (before.has(plane)) turns.push_back(1u << plane);
      for (const unsigned turned : turns) {
        CAPTURE(turned);
        PlanesMemory planes = before;
        const auto turn = [&] {
          for (std::size_t each = 0; each < PlanesMemory::planes; ++each)
            if (turned >> each & 1) planes.turn(each);
        };
        turn();
        draw(planes, over);
        CHECK(planes.kept_to_its_rows());
        for (std::size_t each = 0; each < PlanesMemory::planes; ++each)
          CHECK((planes.bytes[each] != down.bytes[each]) == (before.has(each) && turned >> each & 1));
        turn();
        for (std::size_t each = 0; each < PlanesMemory::planes; ++each)
          CHECK((planes.bytes[each] == down.bytes[each]));
      }
    }
}

}  // namespace swiftgs::test
