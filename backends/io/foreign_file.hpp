// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace swiftgs::io {

/// How many bytes of a file are read to find out what it is.
inline constexpr std::size_t beginning_bytes = 1 << 16;

/// What a file is that nobody knows.
inline constexpr const char* something_else = "something else";

/// Whether a file begins with at least four bytes, or as JSON with keys, that say it is nothing that is read,
/// whatever its name.
bool is_surely_foreign(std::string_view text);

/// What a file is that nobody here reads, and what to give in its place.
std::string foreign_file(std::string_view text, std::string_view name);

/// Whether the name is of a file that people take for a scene, or pack scenes in.
bool is_foreign_name(std::string_view name);

}  // namespace swiftgs::io
