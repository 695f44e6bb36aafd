// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <stdexcept>

#include "device.hpp"

namespace swiftgs::c {

void require_device() {
  throw std::runtime_error("swiftgs_gaussians: arrays on a device, but the library was built without CUDA");
}

void copy_from_device(const void*, std::size_t, void*, void*) { require_device(); }

std::unique_ptr<HostFrames> make_host_frames(const BackendOptions&) { return nullptr; }

}  // namespace swiftgs::c
