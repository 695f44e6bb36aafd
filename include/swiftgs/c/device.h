/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_C_DEVICE_H
#define SWIFTGS_C_DEVICE_H

/// @file
/// Memory and streams of the current CUDA device, for programs that bring no CUDA of their own. A stream is a
/// `cudaStream_t`; NULL is the default stream. Every function fails with `SWIFTGS_UNAVAILABLE` where this
/// build has no device, and with `SWIFTGS_DEVICE_ERROR` where a call to the device does.

#include <stdint.h>

#include <swiftgs/c/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/// The number of the device that is current in this thread, by CUDA's count.
SWIFTGS_C_API swiftgs_status swiftgs_device_current(int32_t* device);

/// Memory of `bytes` bytes, aligned to 256. `SWIFTGS_CAPACITY_ERROR` if there is not enough.
SWIFTGS_C_API swiftgs_status swiftgs_device_allocate(uint64_t bytes, void** memory);
/// Waits for the device.
SWIFTGS_C_API void swiftgs_device_free(void* memory);

/// Copies between any two of host and device, behind the work that `stream` has now. Waits for the copy.
SWIFTGS_C_API swiftgs_status swiftgs_device_copy(void* to, const void* from, uint64_t bytes, void* stream);

/// Has work that `after` is given from now on wait for the work that `before` has now. The host does not
/// wait.
SWIFTGS_C_API swiftgs_status swiftgs_device_order(void* before, void* after);

#ifdef __cplusplus
}
#endif

#endif
