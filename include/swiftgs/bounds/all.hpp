// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/bounds/ellipse.hpp>
#include <swiftgs/bounds/obb.hpp>
#include <swiftgs/bounds/opacity_box.hpp>
#include <swiftgs/bounds/three_sigma_square.hpp>
#include <swiftgs/tools/policy_lists.hpp>

namespace swiftgs {

/// The bounds of the library. Every backend and the table of renderers have these.
using AllBounds = TypeList<ThreeSigmaSquare, OpacityBox, Obb, Ellipse>;

}  // namespace swiftgs
