// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cuda_runtime_api.h>

#include <swiftgs/error.hpp>

namespace swiftgs {

/// Throws `DeviceError`, naming `call`, unless a CUDA call returned success. What failed is not kept as an
/// error of later calls.
inline void check_cuda(cudaError_t result, const char* call) {
  if (result == cudaSuccess) return;
  cudaGetLastError();
  throw DeviceError(call, cudaGetErrorString(result));
}

}  // namespace swiftgs
