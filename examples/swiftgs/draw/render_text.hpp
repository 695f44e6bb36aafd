// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "json.hpp"

namespace swiftgs::cli {

/// Prints an image's file and its frame's times; of a counted frame its statistics too.
void print(const RenderResult& result);

}  // namespace swiftgs::cli
