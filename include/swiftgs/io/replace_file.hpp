// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

#include <swiftgs/frame/api.hpp>

/// @file
/// Files that are whole or as they were: a new one is written beside the old one and takes its place at once.
/// What is no plain file, such as a pipe, is written to as it is; links stay, and lead to the new file.

namespace swiftgs {

/// Calls `write` with the name of the file to write, and puts that in the place of `path` when it returns.
/// Where it throws, `path` keeps what it held. Throws `FileError` with `path`.
SWIFTGS_API void replace_file(const std::filesystem::path& path,
                              const std::function<void(const std::filesystem::path&)>& write);

/// The same with `content`.
SWIFTGS_API void replace_file(const std::filesystem::path& path, std::string_view content);

/// Throws `FileError` with `path` where `replace_file` could not begin, before hours are spent on
/// what goes there. Changes nothing.
SWIFTGS_API void require_replaceable(const std::filesystem::path& path);

}  // namespace swiftgs
