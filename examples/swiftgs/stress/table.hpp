// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stress/results.hpp"

namespace swiftgs::cli {

/// With as many digits as count: 0.03, 2.6 or 104; inf where it is not finite.
std::string error_text(double error);

/// Prints a table for each image size, backend, sort and bounds: a row a family, a column a rasterizer. Then
/// a line for each renderer, and one for each row in which it failed.
void print_stress(const std::vector<StressRow>& rows);

}  // namespace swiftgs::cli
