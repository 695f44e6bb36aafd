// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace swiftgs::cli {

/// Whether `name` matches `pattern`, in which `*` stands for any text and `?` for one character.
bool matches(std::string_view pattern, std::string_view name);

/// Names of the renderers that can run here and match `pattern`. Throws `std::invalid_argument` with a few of
/// the valid names if there is none.
std::vector<std::string> renderers_matching(const std::string& pattern);

/// The renderer that `render` uses unless told otherwise: no approximation beyond float, every tile list
/// exact, on the first backend of `cpu` and `serial` that can run here.
std::string default_renderer();

}  // namespace swiftgs::cli
