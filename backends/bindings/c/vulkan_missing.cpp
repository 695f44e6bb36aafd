// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "device.hpp"

namespace swiftgs::c {

std::unique_ptr<HostFrames> make_vulkan_frames(const BackendOptions&) { return nullptr; }

}  // namespace swiftgs::c
