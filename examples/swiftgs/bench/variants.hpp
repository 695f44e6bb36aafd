// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <swiftgs/scene.hpp>

namespace swiftgs::cli {

/// The parts of `text` between commas. Throws `InvalidArgument`, naming `option`, for an empty one and
/// for one that is there twice.
std::vector<std::string> list_of(const std::string& option, const std::string& text);

/// The same as numbers.
std::vector<double> numbers_of(const std::string& option, const std::string& text);
std::vector<std::size_t> counts_of(const std::string& option, const std::string& text);

/// Throw `InvalidArgument` for a number of Gaussians that is 0 or above 100 million, and for a factor
/// of scales below 0.001 or above 1000.
void require_count(std::size_t count);
void require_factor(double factor);

/// `scene` in another number of Gaussians, so that growth can be measured. Fewer are a random part of it, in
/// the same order. More are split: each becomes two or more of the same opacity, side by side along its
/// longest axis and as much shorter, which together have its mean and its variance; those that become one
/// more than others are random. Throws as `require_count`, and `InvalidArgument` for an empty scene.
Scene with_count(const Scene& scene, std::size_t count, std::uint32_t seed);

/// `scene` with all scales multiplied by `factor`: how many tiles a splat touches, and how full tiles are.
/// Throws as `require_factor`.
Scene enlarged(Scene scene, double factor);

}  // namespace swiftgs::cli
