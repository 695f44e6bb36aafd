// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <swiftgs/c/renderer.h>
#include <swiftgs/view.hpp>

namespace swiftgs::c {

/// Puts the views of `frame` in place of those in `views`. Throws `std::invalid_argument`.
void read_views(const swiftgs_frame& frame, std::vector<View>& views);

}  // namespace swiftgs::c
