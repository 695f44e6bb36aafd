// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/sort/adaptive.hpp>
#include <swiftgs/sort/early.hpp>
#include <swiftgs/sort/standard.hpp>
#include <swiftgs/tools/policy_lists.hpp>

namespace swiftgs {

/// The sorts of the library. The table of renderers has these.
using AllSorts = TypeList<StandardSort, EarlySort, AdaptiveSort>;

}  // namespace swiftgs
