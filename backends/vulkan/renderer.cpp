// SPDX-License-Identifier: Apache-2.0
#include <swiftgs/vulkan.hpp>

namespace swiftgs {

template class BoundRenderer<Vulkan>;

}  // namespace swiftgs
