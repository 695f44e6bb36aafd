// SPDX-License-Identifier: Apache-2.0
// clang-format off
// expected alone_glm_with_swizzle_operators: GLM_FORCE_SWIZZLE and GLM_FORCE_INTRINSICS change how functions take a vec3
// clang-format on
#define GLM_FORCE_INTRINSICS
#ifndef SWIFTGS_EXPECT_COMPILE
#define GLM_FORCE_SWIZZLE
#endif
#include <swiftgs/swiftgs.hpp>
