// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cuda.hpp>
#include <swiftgs/drivers/bound_renderer.hpp>

namespace swiftgs {

template class BoundRenderer<Cuda>;

}  // namespace swiftgs
