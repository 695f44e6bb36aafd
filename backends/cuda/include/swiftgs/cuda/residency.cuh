// SPDX-License-Identifier: Apache-2.0
#pragma once

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
