// SPDX-License-Identifier: Apache-2.0
// expected: expected 3 floats: drop GLM_FORCE_DEFAULT_ALIGNED_GENTYPES
#define GLM_FORCE_INTRINSICS
#ifndef SWIFTGS_EXPECT_COMPILE
#define GLM_FORCE_DEFAULT_ALIGNED_GENTYPES
#endif
#include <swiftgs/swiftgs.hpp>
