// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Checks of the scene and the views of a frame.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/rendering_model.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

namespace detail {
inline void require_for_render(bool holds, const char* expected) {
  if (!holds) refuse("render: expected ", expected);
}

inline void require_finite_background(vec3 background) {
  for (int c = 0; c < 3; ++c)
    if (!is_finite(background[c]))
      refuse("render: the background is ", background[c], " in channel ", c, ", expected finite numbers");
}
}  // namespace detail

/// Throws `InvalidArgument` where nothing can be rendered into `frame`.
inline void validate(const FrameView& frame) {
  detail::require_for_render(frame.width > 0 && frame.height > 0, "a frame with pixels");
  const auto require_plane = [&](const auto& plane, std::size_t pixel, std::size_t channel,
                                 const char* name) {
    const std::size_t row = pixel * std::size_t(frame.width);
    const std::size_t most =
        std::size_t(std::numeric_limits<std::ptrdiff_t>::max()) / std::size_t(frame.height);
    // Unsigned, as the least pitch has no positive counterpart.
    const std::size_t pitch = plane.pitch < 0 ? 0 - std::size_t(plane.pitch) : std::size_t(plane.pitch);
    if (plane.data && (pitch < row || pitch > most || pitch % channel != 0))
      detail::refuse("render: the pitch of ", name, " is ", plane.pitch, " bytes, expected ",
                     pitch > most ? "at most " : "at least ", pitch > most ? most : row,
                     " up or down, a multiple of ", channel);
    if (reinterpret_cast<std::uintptr_t>(plane.data) % channel != 0)
      detail::refuse("render: expected ", name, " aligned to ", channel, " bytes");
  };
  const std::size_t channels = frame.format == PixelFormat::rgb_float ? 3 : 4;
  for_each_plane(
      [&](std::size_t, const auto& plane, std::size_t pixel, const PlaneRow& row) {
        constexpr bool of_colour = std::is_same_v<decltype(plane), const Plane<void>&>;
        require_plane(plane, pixel, of_colour ? pixel / channels : sizeof(float), row.name);
      },
      frame, frame.pixel_bytes(), plane_table);
  detail::require_for_render(!frame.features.data || frame.feature_channels > 0,
                             "a frame with features to say how many channels");
  require_plane(frame.occluder, sizeof(float), sizeof(float), "occluder");
  detail::require_for_render(frame.colour.data || !frame.over, "colour to render over");
  const StoredDepth& by = frame.stored_depth;
  const double determinant = by.p * by.s - by.q * by.r;
  detail::require_for_render(determinant != 0 && detail::is_finite(determinant),
                             "stored depths that are finite and differ");
}

/// Throws `InvalidArgument` where nothing can be rendered of `view`; `Views` checks its tiles.
inline void validate(const View& view) {
  validate(view.frame);
  detail::require_finite_background(view.background);
}

namespace detail {
/// What a row of an array takes. @units{bytes}
struct RowLayout {
  std::size_t bytes, alignment;
};
template <class T>
RowLayout layout_of(const StridedSpan<T>&, std::size_t each) {
  return {each * sizeof(T), sizeof(float)};
}
inline RowLayout layout_of(const HarmonicRows& rows, std::size_t each) {
  return {each * size_of(rows.format), rows.is_packed() ? harmonic_alignment : sizeof(float)};
}
}  // namespace detail

/// Throws `InvalidArgument` where nothing can be rendered from `scene`. Reads no Gaussian.
inline void validate(const SceneView& scene) {
  const std::size_t n = scene.size();
  detail::require_for_render(n <= std::numeric_limits<std::uint32_t>::max(), "fewer than 2^32 Gaussians");
  detail::require_for_render(
      scene.chunks.empty() || (scene.chunks.data && scene.chunks.size == (n + chunk_size - 1) / chunk_size),
      "no chunks in the scene, or one for every 128 Gaussians");
  validate(scene.model);
  detail::require_for_render(scene.sh_degree >= 0 && scene.sh_degree <= max_sh_degree,
                             "an SH degree of 0 to 3");
  detail::require_for_render(scene.feature_channels >= 0 && scene.feature_channels <= max_feature_channels,
                             "0 or more features a Gaussian");
  for_each_array(
      [n](const char* name, std::size_t each, const auto& array) {
        const detail::RowLayout row = detail::layout_of(array, each);
        if (n == 0 || row.bytes == 0) return;
        if (!array.data || array.size != n || array.stride < row.bytes || array.stride % row.alignment != 0)
          detail::refuse("render: ", name, " of the scene: ", array.data ? array.size : 0, " values, ",
                         array.stride, " bytes apart; expected ", n, " values, ", row.bytes,
                         " bytes or more apart, in multiples of ", row.alignment);
      },
      scene);
}

/// Throws `InvalidArgument` where a frame asks for features that `scene` does not have.
inline void require_features(const SceneView& scene, int channels) {
  if (channels > scene.feature_channels)
    detail::refuse("render: the frame asks for ", channels, " features a Gaussian, expected at most the ",
                   scene.feature_channels, " of the scene");
}

}  // namespace swiftgs
