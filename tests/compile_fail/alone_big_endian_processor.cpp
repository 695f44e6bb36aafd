// SPDX-License-Identifier: Apache-2.0
// expected alone_big_endian_processor: SwiftGS: expected a little-endian processor
#ifndef SWIFTGS_EXPECT_COMPILE
#undef __BYTE_ORDER__
#define __BYTE_ORDER__ __ORDER_BIG_ENDIAN__
#endif
#include <swiftgs/swiftgs.hpp>
