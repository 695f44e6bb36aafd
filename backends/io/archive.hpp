// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

/// @file
/// Files that hold other files, for errors that say which of them is the scene.

namespace swiftgs::io {

inline bool is_zip(std::string_view text) { return text.starts_with("PK\3\4"); }
inline bool is_gzip(std::string_view text) { return text.starts_with("\x1f\x8b"); }
inline bool is_tar(std::string_view text) { return text.size() >= 512 && text.substr(257, 5) == "ustar"; }

/// The names of files whose headers are in `text`, the beginning of a tar archive.
std::vector<std::string> names_in_tar(std::string_view text);

/// What kind of archive `archive` is, judged by the `names` of its files, and what to do with it: the end of
/// an error message.
std::string archive_of(const std::string& archive, const std::vector<std::string>& names);

}  // namespace swiftgs::io
