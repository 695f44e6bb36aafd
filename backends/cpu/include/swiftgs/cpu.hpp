// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The backend `Cpu`, for programs.

#include <swiftgs/cpu/stages.hpp>
#include <swiftgs/drivers/bound_renderer.hpp>

namespace swiftgs {

/// In the library, so that programs compile no driver.
extern template class BoundRenderer<Cpu>;

}  // namespace swiftgs
