// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include <swiftgs/cuda/backend.hpp>
#include <swiftgs/cuda/check.hpp>

namespace swiftgs::kernels {

/// `blocks` of `threads`, or as many as fit a multiprocessor of the architecture that is compiled for. For
/// `__launch_bounds__`: ptxas ignores a number that is out of reach, and with it the limit of registers.
constexpr unsigned resident_blocks(unsigned blocks, unsigned threads) {
#if !defined(__CUDA_ARCH__)
  constexpr unsigned most_threads = 2048;
#elif __CUDA_ARCH__ < 800
  constexpr unsigned most_threads = 1024;
#elif (__CUDA_ARCH__ > 800 && __CUDA_ARCH__ < 900) || __CUDA_ARCH__ >= 1100
  constexpr unsigned most_threads = 1536;
#else
  constexpr unsigned most_threads = 2048;
#endif
  return blocks * threads <= most_threads ? blocks : most_threads / threads;
}

}  // namespace swiftgs::kernels

namespace swiftgs {

/// Blocks of `threads` that hold `n` elements.
inline unsigned blocks_for(std::size_t n, unsigned threads) { return unsigned((n + threads - 1) / threads); }

namespace kernels {
/// Waits for the kernels before this one, after an early launch. Every thread calls it before it touches
/// memory or returns. Exception: in a kernel that runs beside its predecessor only some threads call it, no
/// thread block ends before one of these calls has returned, and reads of the predecessor's results are
/// acquires.
__device__ inline void await_earlier() {
#if __CUDA_ARCH__ >= 900
  cudaGridDependencySynchronize();
#endif
}

/// Lets the next kernel start as soon as all thread blocks of this one have started. Few kernels do: waiting
/// blocks displace work on other streams, such as colours beside the sort, which cost 3 % of a frame.
/// Measured on an H200 in an earlier version: where waiting kernels displace colours, a frame of garden takes
/// 405 us, not 398, and one of herz 493, not 485.
__device__ inline void let_next_start() {
#if __CUDA_ARCH__ >= 900
  cudaTriggerProgrammaticLaunchCompletion();
#endif
}
}  // namespace kernels

/// Starts `kernel` on `stream`. Throws `DeviceError` with its name. Errors that the caller's own calls left
/// behind are none of a frame: the launch is judged by its own result.
template <class... Parameters, class... Arguments>
void launch(const char* name, void (*kernel)(Parameters...), dim3 blocks, dim3 threads, cudaStream_t stream,
            const Arguments&... arguments) {
  cudaLaunchConfig_t config{};
  config.gridDim = blocks, config.blockDim = threads, config.stream = stream;
  check_cuda(cudaLaunchKernelEx(&config, kernel, arguments...), name);
}

/// Whether all code of this translation unit is for devices on which kernels can wait for earlier ones.
inline constexpr bool kernels_await_earlier = std::min({__CUDA_ARCH_LIST__}) >= 900;

/// Shape of a thread block.
struct BlockShape {
  unsigned threads;
  std::size_t shared = 0;  ///< dynamic shared memory @units{bytes}

  BlockShape(unsigned threads_, std::size_t shared_ = 0) : threads(threads_), shared(shared_) {}
};

/// Lets `kernel` have the shared memory of `block`, before it is started and before anything is asked of it.
template <class... Parameters>
void allow_shared(void (*kernel)(Parameters...), const BlockShape& block) {
  constexpr std::size_t unasked = 48 * 1024;
  if (block.shared > unasked)
    check_cuda(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, int(block.shared)),
               "cudaFuncSetAttribute");
}

/// As `launch` on the stream of `cuda`, but the device may start thread blocks of `kernel` as those of the
/// kernel before end. This hides launch latency: 12 of a frame's 380 microseconds. The kernel begins with
/// `await_earlier`. Where `early`, blocks come in clusters of so many.
template <unsigned blocks_of_cluster = 1, bool early = kernels_await_earlier, class... Parameters,
          class... Arguments>
void launch_early(const Cuda& cuda, const char* name, void (*kernel)(Parameters...), dim3 blocks,
                  const BlockShape& block, const Arguments&... arguments) {
  cudaLaunchAttribute attributes[2]{};
  attributes[0].id = cudaLaunchAttributeProgrammaticStreamSerialization;
  attributes[0].val.programmaticStreamSerializationAllowed = 1;
  attributes[1].id = cudaLaunchAttributeClusterDimension;
  attributes[1].val.clusterDim.x = blocks_of_cluster;
  attributes[1].val.clusterDim.y = attributes[1].val.clusterDim.z = 1;
  cudaLaunchConfig_t config{};
  config.gridDim = blocks, config.blockDim = block.threads, config.stream = cuda.stream();
  config.dynamicSmemBytes = block.shared;
  config.attrs = attributes, config.numAttrs = !early ? 0 : blocks_of_cluster == 1 ? 1 : 2;
  check_cuda(cudaLaunchKernelEx(&config, kernel, arguments...), name);
}

namespace kernels {
inline constexpr unsigned for_each_threads = 256;

template <class F>
__global__ void __launch_bounds__(for_each_threads) for_each(const Count n, const F f) {
  await_earlier();
  const std::size_t i = std::size_t(blockIdx.x) * for_each_threads + threadIdx.x;
  if (i < n.get()) f(i);
}
}  // namespace kernels

template <class F>
void Cuda::for_each(Count n, const F& f) const {
  if (n.most == 0) return;
  launch_early(*this, "for_each", kernels::for_each<F>, blocks_for(n.most, kernels::for_each_threads),
               kernels::for_each_threads, n, f);
}

}  // namespace swiftgs
