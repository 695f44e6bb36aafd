// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "json.hpp"

namespace swiftgs::cli {

/// Prints where an image is and how long its frame took, and what the frame had to do where it was counted.
void print(const RenderResult& result);

}  // namespace swiftgs::cli
