// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stress/sweep.hpp"

namespace swiftgs::cli {

/// With as many digits as count: 0.03, 2.6 or 104; inf where it is not finite.
std::string error_text(double error);

/// Prints a list for each image size and family: a line a renderer. Then what is to be said of each renderer,
/// and of each row in which it failed.
void print_stress(const std::vector<StressRow>& rows);

}  // namespace swiftgs::cli
