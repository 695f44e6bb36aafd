// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/mpi/ranks.hpp>

namespace swiftgs::test {

/// The ranks that the tests of this program run on.
Ranks& ranks_here();

}  // namespace swiftgs::test
