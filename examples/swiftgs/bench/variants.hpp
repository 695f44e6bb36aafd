// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/scene.hpp>

namespace swiftgs::cli {

/// `scene` in another number of Gaussians, so that growth can be measured. Fewer are a random part of it, in
/// the same order. More are split: each becomes two or more of the same opacity, side by side along its
/// longest axis and as much shorter, which together have its mean and its variance; those that become one
/// more than others are random. @throws std::invalid_argument for `count` 0, or more of an empty scene.
Scene with_count(const Scene& scene, std::size_t count, std::uint32_t seed);

/// `scene` with all scales multiplied by `factor`: how many tiles a splat touches, and how full tiles are.
Scene enlarged(Scene scene, double factor);

}  // namespace swiftgs::cli
