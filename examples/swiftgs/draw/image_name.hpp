// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace swiftgs::cli {

/// `name` without the ending of an image file, such as `.jpg`. Any other dot is part of the name.
std::string_view without_extension(std::string_view name);

}  // namespace swiftgs::cli
