// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <swiftgs/scene.hpp>

namespace swiftgs::io {

/// From 0 to 1 where the viewers that defined the format show it.
vec3 colour_of(const Scene& scene, std::size_t i);

/// All Gaussians, of finite numbers, in the order in which the chunks of a compressed PLY have them. A chunk
/// divides its ranges evenly, so Gaussians of a chunk lie near each other, and those far from all others, or
/// of colours far beyond white, share no chunk with the rest. What such chunks lack of a whole is filled up
/// with the least visible Gaussians. A scene of one chunk cannot be divided.
std::vector<std::uint32_t> order_in_chunks(const Scene& scene);

}  // namespace swiftgs::io
