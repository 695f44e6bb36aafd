// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

#include <swiftgs/drivers/render_settings.hpp>
#include <swiftgs/frame.hpp>

namespace swiftgs::test {

/// Every plane, with so many features.
inline Outputs all_planes(int features = 0) {
  Outputs outputs{.features = features};
  for_each_plane(
      [](std::size_t, auto& wanted) {
        if constexpr (std::is_same_v<decltype(wanted), bool&>) wanted = true;
      },
      outputs);
  return outputs;
}

/// Each plane beside colour alone, with so many features.
inline std::vector<Outputs> each_plane(int features) {
  std::vector<Outputs> each;
  Outputs outputs;
  for_each_plane(
      [&]<class Wanted>(std::size_t, Wanted& wanted) {
        if constexpr (!std::is_const_v<Wanted>)
          wanted = Wanted(features), each.push_back(outputs), wanted = {};
      },
      outputs);
  return each;
}

/// Settings that ask for these planes.
inline RenderSettings settings_of(const Outputs& outputs, vec3 background = vec3(0)) {
  RenderSettings settings;
  settings.outputs = outputs, settings.background = background;
  return settings;
}

}  // namespace swiftgs::test
