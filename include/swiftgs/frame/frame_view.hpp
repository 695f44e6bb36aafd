// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

#include <swiftgs/frame/math.hpp>

/// @file
/// Frames, and their memory. Colours of a frame are in the scene's own values: those of the photographs that
/// it was trained with, usually sRGB-encoded for a display. A scene that was trained in linear light
/// (`RenderingModel::colours`) is blended in it, and its frames are sRGB-encoded too. Otherwise the library
/// converts colours only where `FrameView::conversion` says so. Copy them as they are to an image with
/// encoded values in memory, for example R8G8B8A8_SRGB. A shader that writes them to an sRGB framebuffer
/// needs linear light, because the hardware encodes it; so does a shader that adds them to linear light: let
/// it decode, or `Conversion::srgb_to_linear`. Splats are blended in the scene's values.

namespace swiftgs {

/// Largest image side @units{pixels}.
inline constexpr int max_image_side = 1 << 16;

/// In `id` and `median_id` of a pixel without a Gaussian.
inline constexpr std::uint32_t no_gaussian = 0xffffffff;

/// Format of a frame's colours in memory, interleaved. The last channel of RGBA is the frame's alpha, and the
/// colours are premultiplied by it.
enum class PixelFormat {
  rgb_float,   ///< 12 bytes
  rgba_float,  ///< 16 bytes
  rgba_half,   ///< 8 bytes, IEEE half
  rgba_8,      ///< 4 bytes; cut to [0, 1] and rounded to the nearest of 255 steps
  bgra_8,      ///< the same with blue first, as most swap chains have it
};

/// What makes a frame's colours of the scene's values: the sRGB curve, its inverse, or nothing. Values beyond
/// 0 and 1 are converted by the continued curve, see `to_srgb`.
///
/// Splats are blended in the scene's values. Then straight colours are converted, and multiplied by alpha
/// again where the format has it; alpha is never converted. Where it is 0, colours become 0. The image below
/// (`FrameView::over`) holds the frame's kind of values. A frame without alpha, or before a background that
/// is not black, is a whole picture: its colours are converted as they are.
enum class Conversion {
  as_is,
  srgb_to_linear,  ///< the scene's values are sRGB-encoded; the frame's are linear light
  linear_to_srgb,  ///< the other way round
};

/// @units{bytes}
SWIFTGS_HD constexpr std::size_t bytes_per_pixel(PixelFormat format) {
  switch (format) {
    case PixelFormat::rgb_float:
      return 12;
    case PixelFormat::rgba_float:
      return 16;
    case PixelFormat::rgba_half:
      return 8;
    case PixelFormat::rgba_8:
    case PixelFormat::bgra_8:
      break;
  }
  return 4;
}

/// One plane of a frame in the caller's memory. Null means absent.
///
/// A negative pitch is for memory that begins with the bottom row, as a texture of OpenGL does. `data` still
/// points to the top row of the image, which lies last in such memory:
/// ```
/// std::vector<float> depth(width * height);  // bottom row first
/// Plane<float> plane{&depth[width * (height - 1)], -std::ptrdiff_t(width * sizeof(float))};
/// ```
template <class T>
struct Plane {
  T* data = nullptr;         ///< first pixel of the image's top row
  std::ptrdiff_t pitch = 0;  ///< from a row to the one below it in the image @units{bytes}

  SWIFTGS_HD explicit operator bool() const { return data != nullptr; }

  /// Row y from the top of the image.
  SWIFTGS_HD T* row(std::size_t y) const {
    using Byte = std::conditional_t<std::is_const_v<T>, const unsigned char, unsigned char>;
    return reinterpret_cast<T*>(reinterpret_cast<Byte*>(data) + std::ptrdiff_t(y) * pitch);
  }
  /// The plane from a pixel on, `bytes` to the right and `rows` below.
  Plane from(std::ptrdiff_t bytes, std::ptrdiff_t rows) const {
    using Byte = std::conditional_t<std::is_const_v<T>, const unsigned char, unsigned char>;
    if (!data) return *this;
    return {reinterpret_cast<T*>(reinterpret_cast<Byte*>(data) + bytes + rows * pitch), pitch};
  }
  bool operator==(const Plane&) const = default;
};

/// Planes that a frame gets: colour, and others by choice.
struct Outputs {
  static constexpr bool colour = true;
  bool alpha = false;
  bool depth = false;
  // As of `PerPlane`.
  bool squared_depth = false, first_depth = false, median_depth = false;
  bool normal = false;
  bool id = false, median_id = false;
  int features = 0;  ///< number of channels: the scene's first ones
};

namespace detail {
/// References to the planes of `of`, in the order of `plane_table`.
constexpr auto planes_of(auto& of) {
  return std::tie(of.colour, of.alpha, of.depth, of.squared_depth, of.first_depth, of.median_depth, of.normal,
                  of.id, of.median_id, of.features);
}
}  // namespace detail

/// A value for each plane of a frame: `T`, or `Id` for planes of Gaussians.
///
/// A splat's weight in a pixel is alpha times the transmittance in front of it. A Gaussian's index is that in
/// the scene. Depths are as `Conventions::depth` has them.
template <class T, class Id = T>
struct PerPlane {
  T colour{};         ///< 3 channels: RGB in the scene's own values, not cut above
  T alpha{};          ///< 1 - transmittance
  T depth{};          ///< mean by weight; 0 where alpha is 0
  T squared_depth{};  ///< mean by weight of depth^2; 0 where alpha is 0
  T first_depth{};    ///< of the splat that takes alpha above `Conventions::first_alpha`; 0 where none does
  T median_depth{};   ///< of the splat that takes alpha above 1/2; 0 where none does
  T normal{};         ///< 3 channels: sum of weight times `splat_normal`
  Id id{};            ///< Gaussian of the largest weight, of equal ones the nearest; or `no_gaussian`
  Id median_id{};     ///< Gaussian of `median_depth`; or `no_gaussian`
  T features{};       ///< as many channels as the frame asks for: sum of weight times feature

  static auto buffers(auto& self) { return detail::planes_of(self); }
};

/// What a view is asked for: planes, and that its occluder hides splats. Planning reads it. Where planes go
/// is known to a `FrameView`, which may follow later.
struct Request {
  bool colour : 1 = false, alpha : 1 = false, depth : 1 = false;
  bool squared_depth : 1 = false, first_depth : 1 = false, median_depth : 1 = false;
  bool normal : 1 = false, id : 1 = false, median_id : 1 = false, features : 1 = false;
  bool occluder : 1 = false;

  /// The planes that are true of `of`, `Outputs` or a `FrameView`.
  template <class Of>
  static constexpr Request planes_of(const Of& of) {
    return {bool(of.colour),      bool(of.alpha),        bool(of.depth),  bool(of.squared_depth),
            bool(of.first_depth), bool(of.median_depth), bool(of.normal), bool(of.id),
            bool(of.median_id),   bool(of.features)};
  }
  /// For `for_each_plane`.
  constexpr PerPlane<bool> planes() const {
    return {colour, alpha, depth, squared_depth, first_depth, median_depth, normal, id, median_id, features};
  }
  bool operator==(const Request&) const = default;
};

/// What a pixel makes of the splats that it shows, front to back.
enum class Accumulator {
  sum,   ///< by weight
  mean,  ///< by weight; 0 where alpha is 0
  pick,  ///< value of one splat; 0 or `no_gaussian` where there is none
};

/// Properties of a plane. The type of its values is that of the plane's member of `Frame`.
struct PlaneRow {
  const char* name = nullptr;
  int channels = 0;  ///< of a pixel; 0: as many as the frame asks for
  Accumulator accumulator = Accumulator::sum;
  int length_power = 0;            ///< values are in the scene's unit of length to this power
  const char* channel_names[3]{};  ///< in an EXR; channels that a frame asks for have numbers behind
};

/// The table of planes. Whatever treats all planes loops over it by `for_each_plane`.
inline constexpr PerPlane<PlaneRow> plane_table{
    .colour = {"colour", 3, Accumulator::sum, 0, {"R", "G", "B"}},
    .alpha = {"alpha", 1, Accumulator::sum, 0, {"A"}},
    .depth = {"depth", 1, Accumulator::mean, 1, {"Z"}},
    .squared_depth = {"squared_depth", 1, Accumulator::mean, 2, {"depth.squared"}},
    .first_depth = {"first_depth", 1, Accumulator::pick, 1, {"depth.first"}},
    .median_depth = {"median_depth", 1, Accumulator::pick, 1, {"depth.median"}},
    .normal = {"normal", 3, Accumulator::sum, 0, {"normal.X", "normal.Y", "normal.Z"}},
    .id = {"id", 1, Accumulator::pick, 0, {"id.gaussian"}},
    .median_id = {"median_id", 1, Accumulator::pick, 0, {"id.median"}},
    .features = {"features", 0, Accumulator::sum, 0, {"features."}},
};

namespace detail {
/// Feature channels that `of` asks for or holds; 0 if it is a value for each plane.
template <class Of>
constexpr int feature_channels(const Of& of) {
  if constexpr (std::is_same_v<Of, Outputs>)
    return of.features;
  else if constexpr (requires { of.feature_channels; })
    return of.feature_channels;
  else
    return 0;
}
}  // namespace detail

/// Calls f(channels, of.plane...) for each plane, in the order of `plane_table`. `of` are any of `Frame`,
/// `FrameView`, `Outputs`, `PerPlane`, `plane_table` and the like. Those that know the channels of features
/// agree on them.
template <class F, class... Of>
constexpr void for_each_plane(const F& f, Of&&... of) {
  const int features = std::max({0, detail::feature_channels(of)...});
  const auto rows = detail::planes_of(plane_table);
  const auto call = [&]<std::size_t plane>() {
    const int channels = std::get<plane>(rows).channels;
    f(std::size_t(channels != 0 ? channels : features), std::get<plane>(detail::planes_of(of))...);
  };
  [&]<std::size_t... planes>(std::index_sequence<planes...>) { (call.template operator()<planes>(), ...); }
  (std::make_index_sequence<std::tuple_size_v<decltype(rows)>>());
}

/// How values of a depth buffer stand for depths: value d for (p d + q) / (r d + s). Where r d + s is not
/// above 0, as at the far end of an infinite projection, there is nothing. By default d is the depth itself.
struct StoredDepth {
  double p = 1, q = 0, r = 0, s = 1;

  /// Of a perspective projection of OpenGL (its window depth), Vulkan or Direct3D, by the depths at the
  /// values 0 and 1: those of the near and the far plane, or of the far and the near one if depth is
  /// reversed. Either may be infinite.
  static StoredDepth perspective(double at_0, double at_1) { return {0, 1, 1 / at_1 - 1 / at_0, 1 / at_0}; }
  /// Of an orthographic projection.
  static StoredDepth orthographic(double at_0, double at_1) { return {at_1 - at_0, at_0, 0, 1}; }

  /// The depth that `value` stands for; infinite for nothing.
  SWIFTGS_HD float depth(float value) const {
    if (p == 1 && q == 0 && r == 0 && s == 1) return value;  // -infinity and NaN too
    const double below = r * value + s;
    return below > 0 ? float((p * value + q) / below) : INFINITY;
  }
  bool operator==(const StoredDepth&) const = default;
};

/// Destination of a frame: the caller's memory, reachable by the backend. Each plane has a pitch of its own,
/// and so a direction: rows go down in memory or up. Absent planes are not computed.
struct FrameView {
  int width = 0, height = 0;
  Plane<void> colour{};  ///< of `format`
  PixelFormat format = PixelFormat::rgb_float;
  // As of `PerPlane`.
  Plane<float> alpha{}, depth{}, squared_depth{}, first_depth{}, median_depth{};
  Plane<float> normal{};  ///< XYZ interleaved
  Plane<std::uint32_t> id{}, median_id{};
  Plane<float> features{};   ///< `feature_channels` interleaved
  int feature_channels = 0;  ///< their number: the scene's first ones

  /// The caller's own depth buffer: a splat at a pixel's depth there, or behind it, is not blended. Its
  /// depths are measured as `Conventions::depth` has it, and stored as `stored_depth` says. Infinity and NaN
  /// hide nothing.
  Plane<const float> occluder{};
  StoredDepth stored_depth{};

  /// Show the image that `colour` already holds, instead of the background, behind the splats.
  bool over = false;
  Conversion conversion = Conversion::as_is;  ///< of `colour`

  std::size_t pixels() const { return std::size_t(width) * height; }
  /// The planes that have memory.
  Request request() const {
    Request all = Request::planes_of(*this);
    all.occluder = bool(occluder);
    return all;
  }
  /// @units{bytes}
  PerPlane<std::size_t> pixel_bytes() const {
    PerPlane<std::size_t> bytes;
    for_each_plane([](std::size_t channels, const auto&, std::size_t& of) { of = channels * sizeof(float); },
                   *this, bytes);
    bytes.colour = bytes_per_pixel(format);
    return bytes;
  }

  /// Whether a pixel has to remember splats.
  SWIFTGS_HD bool picks() const { return first_depth.data || median_depth.data || id.data || median_id.data; }

  /// A rectangle of it, whose first pixel is the one at column `left` and row `top`.
  FrameView part(int left, int top, int columns, int rows) const {
    FrameView out = *this;
    out.width = columns, out.height = rows;
    for_each_plane([&](std::size_t, auto& plane,
                       std::size_t pixel) { plane = plane.from(left * std::ptrdiff_t(pixel), top); },
                   out, pixel_bytes());
    out.occluder = occluder.from(left * std::ptrdiff_t(sizeof(float)), top);
    return out;
  }

  /// Depth of what hides splats at a pixel of a frame with an occluder.
  SWIFTGS_HD float occluder_at(std::size_t x, std::size_t y) const {
    return stored_depth.depth(occluder.row(y)[x]);
  }
  bool operator==(const FrameView&) const = default;
};

}  // namespace swiftgs
