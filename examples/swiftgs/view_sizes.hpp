// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "options.hpp"
#include "views.hpp"

namespace swiftgs::cli {

/// Views of one image size.
struct SizeGroup {
  std::vector<View> views;
  std::vector<View> checked;  ///< those of them that a choice is compared on
};

/// All views at all `scales`, by size, of which those that `options.views` chooses are checked; none where
/// that is empty. Throws `std::invalid_argument` where two scales give a view the same size, and as
/// `views_of`.
std::vector<SizeGroup> group_by_size(const Cameras& cameras, const ViewOptions& options,
                                     const std::vector<double>& scales);

}  // namespace swiftgs::cli
