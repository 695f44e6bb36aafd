// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <memory>

#include "device.hpp"

namespace swiftgs::c {

std::unique_ptr<HostFrames> make_vulkan_frames(const BackendOptions&) { return nullptr; }
void update_vulkan_scene(AnyRenderer&, std::size_t, std::size_t, SceneArrays) {}

}  // namespace swiftgs::c
