// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include <swiftgs/cuda/launch.cuh>
#include <swiftgs/cuda/stages.hpp>

namespace swiftgs {

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
