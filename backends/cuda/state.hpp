// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <tuple>

#include <cuda_runtime_api.h>

#include <swiftgs/cuda/stages.hpp>

namespace swiftgs {

namespace detail {
struct DestroyEvent {
  void operator()(cudaEvent_t event) const { cudaEventDestroy(event); }
};
struct DestroyStream {
  void operator()(cudaStream_t stream) const { cudaStreamDestroy(stream); }
};
struct FreeHost {
  void operator()(void* memory) const { cudaFreeHost(memory); }
};
}  // namespace detail
using OwnedEvent = std::unique_ptr<CUevent_st, detail::DestroyEvent>;
using OwnedStream = std::unique_ptr<CUstream_st, detail::DestroyStream>;

/// Host memory in which a kernel leaves a report.
struct Mailbox {
  FrameReport report;
  std::uint32_t raster_word = 0;  ///< `RasterMemory::word`
  std::uint32_t posted = 0;       ///< not 0 once all is there
};

/// How many keys have each digit, in each pass of a sort.
struct RadixCounts {
  static constexpr unsigned digits = 256;
  std::uint32_t of_pass[kernels::most_passes][digits];
};

/// What the rasterizers of a backend keep from frame to frame, until `Cuda::trim`.
struct RasterMemory {
  static RasterMemory& of(const Cuda& cuda);

  DeviceBuffer<std::byte> scratch;
  DeviceBuffer<std::uint32_t> order;  ///< of raster blocks
  DeviceBuffer<vec4> colours;         ///< of frames that convert them
  DeviceBuffer<View> views;           ///< whose planes were replaced
  DeviceBuffer<std::uint32_t> word;   ///< one counter of quiet frames, which kernels keep
  /// The word as the host knows it: from the last report that it has awaited, so before that frame was
  /// rasterized. 0 before the first report, and while frames are recorded.
  std::uint32_t known_word = 0;

  /// At least `size` elements of one of them. Zeroed when they are allocated, and not again. Throws if it
  /// must grow while the stream is being captured.
  template <class T>
  static T* at_least(const Cuda& cuda, DeviceBuffer<T>& memory, std::size_t size) {
    if (memory.size() < size) {
      cuda.check_not_captured("rasterize");
      memory.reset(size);
      try {
        cuda.clear(memory.data(), memory.size() * sizeof(T));
      } catch (const DeviceError&) {
        memory.trim();
        throw;
      }
    }
    return memory.data();
  }

  static auto buffers(auto& self) {
    return std::tie(self.scratch, self.order, self.colours, self.views, self.word);
  }
};

/// What a backend keeps from frame to frame.
struct Cuda::State {
  /// A second stream.
  struct Side {
    OwnedStream stream;       ///< made when it is needed
    OwnedEvent begun, ended;  ///< made with it
    bool forked = false;      ///< whether the backend's stream has not been told to wait for it
    bool captured = false;    ///< whether it forked while the backend's stream was being captured

    void make();
  };

  State(cudaStream_t of, const MemoryHook& hook) : stream(of), memory(hook) {
    use_memory(memory, temporary, total, raster, sorts);
  }

  /// Longest copy that goes through pinned memory. Measured on an H100: the 82 KB of a pick in 64x64 pixels
  /// take 72 us to memory that is not pinned, kernel included, and 43 through this.
  static constexpr std::size_t staging_bytes = 128 * 1024;

  bool being_captured(const char* call) const;
  void check_not_captured(const char* call) const;
  void join();
  void wait() const;
  void copy_to_host(const void* from, void* to, std::size_t bytes);

  cudaStream_t stream;
  MemoryHook memory;
  Side side;
  std::array<OwnedEvent, 256> events;                    ///< a ring, made as they are needed
  std::uint64_t points = 0;                              ///< taken so far
  std::unique_ptr<Mailbox, detail::FreeHost> mailbox;    ///< made when it is needed
  std::unique_ptr<std::byte, detail::FreeHost> staging;  ///< likewise, for short copies to the host
  bool awaited = false;                                  ///< whether a kernel may still post to it
  int multiprocessors = 0, shared_memory = 0;            ///< 0: not yet asked for

  DeviceBuffer<std::byte> temporary;  ///< of CUB
  DeviceBuffer<std::uint64_t> total;  ///< of a scan
  RasterMemory raster;

  Epochs<RadixCounts> sorts;
};

}  // namespace swiftgs
