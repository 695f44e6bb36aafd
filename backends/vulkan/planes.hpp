// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <swiftgs/error.hpp>
#include <swiftgs/frame.hpp>

#include "hazards.hpp"

namespace swiftgs::vulkan {

/// The memory of a plane, whose rows may go up.
template <class T>
Access pixels_of(const Plane<T>& plane, int height, Access::How how) {
  const std::ptrdiff_t rows = plane.pitch * (height - 1);
  const void* const first = plane.data;
  const auto* const lowest = static_cast<const std::byte*>(first) + std::min<std::ptrdiff_t>(rows, 0);
  const std::ptrdiff_t bytes = std::max(rows, -rows) + std::max(plane.pitch, -plane.pitch);
  return {plane.data ? lowest : nullptr, std::size_t(bytes), how};
}

/// Shaders write words: a pixel may not begin within one.
inline void check_colours(const FrameView& frame) {
  const auto address = reinterpret_cast<std::uintptr_t>(frame.colour.data);
  if (address % 4 != 0 || frame.colour.pitch % 4 != 0)
    detail::refuse("backend vulkan: colours at ", address, " with a pitch of ", frame.colour.pitch,
                   " bytes, expected multiples of 4");
}

}  // namespace swiftgs::vulkan
