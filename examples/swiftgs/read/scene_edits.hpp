// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <variant>
#include <vector>

#include <swiftgs/edit/all.hpp>

namespace swiftgs::cli {

using Region = std::variant<Box, Sphere, HalfSpace>;

/// The movement that `--transform` names: `scale:S`, `scale:X,Y,Z` along the axes, `move:X,Y,Z`,
/// `rotate:X,Y,Z,DEGREES` about an axis through the origin, or `matrix:` and twelve numbers, three rows of
/// four. Throws `InvalidArgument`.
Affine movement_named(const std::string& text);

/// The region that `--crop` names: `box:X,Y,Z,X,Y,Z`, `sphere:X,Y,Z,RADIUS` or `half-space:X,Y,Z,OFFSET`.
/// Throws `InvalidArgument`.
Region region_named(const std::string& text);

}  // namespace swiftgs::cli
