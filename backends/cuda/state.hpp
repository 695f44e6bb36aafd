// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda.hpp>

namespace swiftgs {

/// What a backend keeps from frame to frame.
struct Cuda::State {
  struct DestroyEvent {
    void operator()(cudaEvent_t event) const { cudaEventDestroy(event); }
  };

  struct FreeHost {
    void operator()(FrameCounts* memory) const { cudaFreeHost(memory); }
  };

  cudaStream_t stream = nullptr;
  std::array<std::unique_ptr<CUevent_st, DestroyEvent>, 256> events;  ///< a ring, made as they are needed
  std::uint64_t points = 0;                                           ///< taken so far
  DeviceBuffer<std::byte> temporary;                                  ///< of CUB
  std::unique_ptr<FrameCounts, FreeHost> counts;                      ///< where copies need no further one
  DeviceBuffer<std::uint64_t> total;                                  ///< of a scan
};

}  // namespace swiftgs
