// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <swiftgs/cuda/check.hpp>

namespace swiftgs {

/// Blocks of `threads` that hold `n` elements.
inline unsigned blocks_for(std::size_t n, unsigned threads) { return unsigned((n + threads - 1) / threads); }

/// Starts `kernel` on `stream`. Throws `DeviceError` with its name.
template <class... Parameters, class... Arguments>
void launch(const char* name, void (*kernel)(Parameters...), unsigned blocks, dim3 threads,
            cudaStream_t stream, const Arguments&... arguments) {
  kernel<<<blocks, threads, 0, stream>>>(arguments...);
  check_cuda(cudaGetLastError(), name);
}

}  // namespace swiftgs
