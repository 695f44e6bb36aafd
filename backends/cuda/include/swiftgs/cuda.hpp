// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The backend `Cuda`, for programs.

#include <swiftgs/cuda/features.hpp>
#include <swiftgs/drivers/bound_renderer.hpp>

namespace swiftgs {

/// In the library, so that programs compile no driver.
extern template class BoundRenderer<Cuda>;

}  // namespace swiftgs
