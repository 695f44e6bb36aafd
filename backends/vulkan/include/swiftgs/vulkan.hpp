// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The backend `Vulkan`, for programs.

#include <swiftgs/drivers/bound_renderer.hpp>
#include <swiftgs/vulkan/stages.hpp>

namespace swiftgs {

/// In the library, so that programs compile no driver.
extern template class BoundRenderer<Vulkan>;

}  // namespace swiftgs
