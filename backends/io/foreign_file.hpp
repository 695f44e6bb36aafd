// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace swiftgs::io {

/// What a file is that no reader of scenes takes, for an error: what people take for a scene most often
/// deserves its name. Of an archive it tells the scenes in it and what to do.
std::string what_it_is(std::string_view text);

/// Whether a file begins with at least four bytes that say it is no scene, whatever its name.
bool is_surely_foreign(std::string_view text);

}  // namespace swiftgs::io
