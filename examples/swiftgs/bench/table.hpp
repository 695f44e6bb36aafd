// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bench/results.hpp"

namespace swiftgs::cli {

/// Prints `rows` as Markdown: for each scene, size of images, conventions and number of threads the means of
/// each renderer over its views with the worst error, the quickest first.
void print_tables(const std::vector<RowResult>& rows);

}  // namespace swiftgs::cli
