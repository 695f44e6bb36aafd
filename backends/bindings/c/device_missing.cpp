// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <memory>
#include <string>

#include <swiftgs/error.hpp>

#include "device.hpp"

namespace swiftgs::c {

void require_device(const char* what) {
  throw Unavailable(std::string(what) + ", but the library was built without CUDA");
}

int current_device() { return 0; }
void* allocate_memory(std::size_t) { return nullptr; }
void free_memory(void*) {}
void copy_memory(void*, const void*, std::size_t, void*) {}
void order_streams(void*, void*) {}

std::unique_ptr<HostFrames> make_cuda_frames(const BackendOptions&) { return nullptr; }

}  // namespace swiftgs::c
