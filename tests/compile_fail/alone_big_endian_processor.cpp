// SPDX-License-Identifier: Apache-2.0
// expected: SwiftGS: expected a little-endian processor
#ifndef SWIFTGS_EXPECT_COMPILE
#undef __BYTE_ORDER__
#define __BYTE_ORDER__ __ORDER_BIG_ENDIAN__
#endif
#include <swiftgs/swiftgs.hpp>
