// SPDX-License-Identifier: Apache-2.0

// Memory and streams of a device, for languages that bring no CUDA of their own.
#include <cstddef>

#include <swiftgs/c/device.h>

#include "device.hpp"
#include "error.hpp"

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_device_current(int32_t* device) {
  return guarded([&] {
    require_pointer(device, "device");
    require_device("swiftgs_device_current: a device");
    *device = current_device();
  });
}

swiftgs_status swiftgs_device_allocate(uint64_t bytes, void** memory) {
  return guarded([&] {
    require_pointer(memory, "memory");
    require_device("swiftgs_device_allocate: memory of a device");
    *memory = allocate_memory(std::size_t(bytes));
  });
}

void swiftgs_device_free(void* memory) {
  if (memory) free_memory(memory);
}

swiftgs_status swiftgs_device_copy(void* to, const void* from, uint64_t bytes, void* stream) {
  return guarded([&] {
    require_device("swiftgs_device_copy: memory of a device");
    if (bytes == 0) return;
    require_pointer(to, "to");
    require_pointer(from, "from");
    copy_memory(to, from, std::size_t(bytes), stream);
  });
}

swiftgs_status swiftgs_device_order(void* before, void* after) {
  return guarded([&] {
    require_device("swiftgs_device_order: streams of a device");
    order_streams(before, after);
  });
}

}  // extern "C"
