// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/sort/adaptive.hpp>
#include <swiftgs/sort/early.hpp>
#include <swiftgs/sort/standard.hpp>
#include <swiftgs/type_list.hpp>

namespace swiftgs {

/// The sorts of the library. The table of renderers has these. Each names in `Loops` the functors
/// that it runs by `for_each` itself: a device's compiler must see them.
using AllSorts = TypeList<StandardSort, EarlySort, AdaptiveSort>;

}  // namespace swiftgs
