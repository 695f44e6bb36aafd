// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <swiftgs/api.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/views.hpp>

/// @file
/// What ranks compare before they trust each other.

namespace swiftgs {

/// The library's version, and a checksum of the program with the library's shared objects: ranks may have
/// been started from different files.
SWIFTGS_API std::string build_identity();

/// Size and checksum of a file: of all of it up to 1 MiB; of a larger one, of its first and last 64 KiB and
/// of 64 blocks of 4 KiB between. It tells another scene, and one that was trained on; a few numbers changed
/// by hand may escape it. Throws `std::system_error`.
SWIFTGS_API std::string file_identity(const std::filesystem::path& path);

/// Of all that says what the views of a frame show, their memory aside.
SWIFTGS_API std::uint64_t views_identity(Span<const View> views);

}  // namespace swiftgs
