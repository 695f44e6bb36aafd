// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cooperative_groups.h>

namespace swiftgs::kernels {

/// Blocks that work on one thing: one, or the `blocks_of_group` of a cluster.
inline constexpr unsigned blocks_of_group = 8;

struct Group {
  unsigned rank = 0, blocks = 1;

  /// The cluster of this block.
  __device__ static Group cluster() {
#if __CUDA_ARCH__ >= 900
    const auto all = cooperative_groups::this_cluster();
    if (all.num_blocks() == blocks_of_group) return {all.block_rank(), blocks_of_group};
#endif
    return {};
  }

  __device__ void sync() const {
#if __CUDA_ARCH__ >= 900
    if (blocks != 1) {
      cooperative_groups::this_cluster().sync();
      return;
    }
#endif
    __syncthreads();
  }

  /// `mine` in the shared memory of block `block`.
  template <class T>
  __device__ T& in(unsigned block, T& mine) const {
#if __CUDA_ARCH__ >= 900
    if (blocks != 1) return *cooperative_groups::this_cluster().map_shared_rank(&mine, block);
#endif
    return mine;
  }
};

}  // namespace swiftgs::kernels
