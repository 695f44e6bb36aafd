// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cuda/features.hpp>
#include <swiftgs/functor/count_on_host.hpp>

namespace swiftgs {

FrameCounted count_frame(const Cuda& cuda, const RasterJob& from, CountRasterBlock count) {
  return count_on_host(cuda, from, count);
}

}  // namespace swiftgs
