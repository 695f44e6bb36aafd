// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <swiftgs/c/renderer.h>
#include <swiftgs/c/view.h>
#include <swiftgs/frame.hpp>
#include <swiftgs/view.hpp>

namespace swiftgs::c {

template <class T>
Plane<T> to_plane(const swiftgs_plane& from) {
  return {static_cast<T*>(from.data), std::ptrdiff_t(from.pitch)};
}

/// Numbers of `swiftgs_view::format`.
inline constexpr int format_count = 5;

/// Sets the planes of `frame` to those of `from`, a struct of the C interface.
template <class From>
void set_planes(FrameView& frame, const From& from) {
  frame.feature_channels = from.feature_channels;
  for_each_plane(
      []<class T>(std::size_t, Plane<T>& to, const swiftgs_plane& plane) { to = to_plane<T>(plane); }, frame,
      from);
}

/// Puts the views of `frame` in place of those in `views`. Throws `InvalidArgument`.
void read_views(const swiftgs_frame& frame, std::vector<View>& views);

}  // namespace swiftgs::c
