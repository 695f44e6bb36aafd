// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

/// @file
/// The version of the library. The build reads it from here; it is written nowhere else.

/// Forward rendering of 3D Gaussian splatting, composed of policies.
namespace swiftgs {

inline constexpr int version_major = 0;  ///< raised by a change that breaks callers
inline constexpr int version_minor = 1;  ///< raised by an addition
inline constexpr int version_patch = 0;  ///< raised by a correction

/// `major.minor.patch`.
inline constexpr std::string_view version = "0.1.0";

}  // namespace swiftgs
