// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

/// @file
/// The version of the library. The build reads it from here.
///
/// Until 1.0 the binary interface changes with each minor version, and shared libraries are named for it
/// (libswiftgs.so.0.1). A program includes the headers of the library that it links: much of the library is
/// templates that the program instantiates.

/// The version as the preprocessor knows it, for `#if`.
#define SWIFTGS_VERSION_MAJOR 0
#define SWIFTGS_VERSION_MINOR 1
#define SWIFTGS_VERSION_PATCH 0

/// `SWIFTGS_VERSION_AT_LEAST(0, 1, 0)`
#define SWIFTGS_VERSION_AT_LEAST(major, minor, patch)                                        \
  (SWIFTGS_VERSION_MAJOR * 1000000 + SWIFTGS_VERSION_MINOR * 1000 + SWIFTGS_VERSION_PATCH >= \
   (major)*1000000 + (minor)*1000 + (patch))

/// Forward rendering of 3D Gaussian splatting, composed of policies.
namespace swiftgs {

inline constexpr int version_major = SWIFTGS_VERSION_MAJOR;  ///< raised by a change that breaks callers
inline constexpr int version_minor = SWIFTGS_VERSION_MINOR;  ///< raised by an addition
inline constexpr int version_patch = SWIFTGS_VERSION_PATCH;  ///< raised by a correction

/// `major.minor.patch`.
inline constexpr std::string_view version = "0.1.0";

}  // namespace swiftgs
