// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/statistics.hpp>

#include "json_text.hpp"

namespace swiftgs::cli {

/// Of one counted frame, which takes longer than others. @units{milliseconds}
struct CountedTimes {
  double raster = 0;
  double balanced = 0;  ///< as `Statistics::balanced_ms`

  CountedTimes() = default;
  CountedTimes(const StageTimes& times, const Statistics& counts)
      : raster(times.raster), balanced(counts.balanced_ms()) {}
};

inline Json json_of(const CountedTimes& times) {
  return {{"raster", rounded(times.raster)}, {"balanced", rounded(times.balanced)}};
}

}  // namespace swiftgs::cli
