// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/bound_renderer.hpp>
#include <swiftgs/cuda.hpp>

namespace swiftgs {

template class BoundRenderer<Cuda>;

}  // namespace swiftgs
