// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

/// @file
/// The version of the library, stated here alone: CMake, pkg-config, C, Python and the command line take it
/// from here.
///
/// Until 1.0 a minor version may change the C++ interface, and shared libraries are named for it
/// (libswiftgs.so.0.2). A program includes the headers of the library that it links: much of the library is
/// templates that the program instantiates.

/// The version as the preprocessor knows it, for `#if`.
#define SWIFTGS_VERSION_MAJOR 0
#define SWIFTGS_VERSION_MINOR 2
#define SWIFTGS_VERSION_PATCH 0

/// `SWIFTGS_VERSION_AT_LEAST(0, 2, 0)`
#define SWIFTGS_VERSION_AT_LEAST(major, minor, patch)                                        \
  (SWIFTGS_VERSION_MAJOR * 1000000 + SWIFTGS_VERSION_MINOR * 1000 + SWIFTGS_VERSION_PATCH >= \
   (major)*1000000 + (minor)*1000 + (patch))

/// Forward rendering of 3D Gaussian splatting, composed of policies.
namespace swiftgs {

inline constexpr int version_major = SWIFTGS_VERSION_MAJOR;  ///< raised by a change that breaks callers
inline constexpr int version_minor = SWIFTGS_VERSION_MINOR;  ///< raised by an addition
inline constexpr int version_patch = SWIFTGS_VERSION_PATCH;  ///< raised by a correction

/// `major.minor.patch`.
inline constexpr std::string_view version = "0.2.0";

}  // namespace swiftgs
