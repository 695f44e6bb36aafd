// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace swiftgs {

/// What was measured of the sort of one view of a scene at one image size: mean time of either strategy.
struct SortCalibration {
  std::size_t gaussians = 0;
  int width = 0, height = 0;
  double standard_ms = 0, early_ms = 0;  ///< @units{milliseconds}

  bool prefers_early() const { return early_ms <= standard_ms; }
};

}  // namespace swiftgs
