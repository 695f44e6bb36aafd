// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/scene.hpp>

#include "axis_flip.hpp"
#include "loss_meter.hpp"
#include "spz_content.hpp"

/// @file
/// The quantised values of SPZ versions 3 and 4, encoded.

namespace swiftgs::io {

/// How numbers of a scene become those of a file.
struct SpzEncoding {
  AxisFlip flip{};  ///< from RDF to the axes of the file
  int fractional_bits = 0;
};

/// Encodes an attribute of Gaussians [begin, end), all of finite numbers. Returns how many values lie outside
/// of what the format holds, and were clamped.
std::uint64_t encode_spz(const Scene& scene, const SpzEncoding& encoding, SpzAttribute attribute,
                         std::size_t begin, std::size_t end, std::byte* to);

/// Tells `losses` what an attribute of Gaussians [begin, end) became, unless it is rotations or harmonics.
void measure_spz(const SpzHeader& header, const AxisFlip& flip, SpzAttribute attribute, std::size_t begin,
                 std::size_t end, const std::byte* from, LossMeter& losses);

}  // namespace swiftgs::io
