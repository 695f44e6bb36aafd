// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <swiftgs/frame.hpp>

namespace swiftgs::cli {

/// The colours of `frame` in 8 bits, as a PNG has them. @shape{height, width, 3} Reuses the memory of
/// `bytes`.
inline void to_rgb_bytes(const Frame& frame, std::vector<unsigned char>& bytes) {
  bytes.resize(frame.colour.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const float value = frame.colour[i] > 0 ? frame.colour[i] : 0;  // a NaN becomes 0
    bytes[i] = static_cast<unsigned char>(255 * (value < 1 ? value : 1) + 0.5f);
  }
}

}  // namespace swiftgs::cli
