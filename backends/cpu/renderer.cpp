// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/cpu.hpp>
#include <swiftgs/drivers/bound_renderer.hpp>

namespace swiftgs {

template class BoundRenderer<Cpu>;

}  // namespace swiftgs
