// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/serial.hpp>
#include <swiftgs/swiftgs.hpp>
#include <swiftgs/vulkan.hpp>

namespace swiftgs::test {

using UsualVulkan = Renderer<Vulkan>;
using UsualSerial = Renderer<Serial>;

inline RenderSettings with_planes() {
  RenderSettings settings;
  settings.outputs.alpha = settings.outputs.depth = true;
  settings.outputs.first_depth = settings.outputs.median_depth = true;
  settings.outputs.id = settings.outputs.median_id = true;
  settings.background = vec3(0.25f, 0.5f, 0.125f);
  return settings;
}

}  // namespace swiftgs::test
