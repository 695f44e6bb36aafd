// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/frame.hpp>
#include <swiftgs/render_settings.hpp>

namespace swiftgs::test {

/// Every plane, with so many features.
inline Outputs all_planes(int features = 0) {
  return {.alpha = true,
          .depth = true,
          .squared_depth = true,
          .first_depth = true,
          .median_depth = true,
          .normal = true,
          .id = true,
          .median_id = true,
          .features = features};
}

/// Settings that ask for these planes.
inline RenderSettings settings_of(const Outputs& outputs, vec3 background = vec3(0)) {
  RenderSettings settings;
  settings.outputs = outputs, settings.background = background;
  return settings;
}

}  // namespace swiftgs::test
