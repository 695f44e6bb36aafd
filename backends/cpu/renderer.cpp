// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/bound_renderer.hpp>
#include <swiftgs/cpu.hpp>

namespace swiftgs {

template class BoundRenderer<Cpu>;

}  // namespace swiftgs
