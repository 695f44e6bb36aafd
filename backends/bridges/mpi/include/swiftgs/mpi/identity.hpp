// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/lens/view.hpp>

/// @file
/// What ranks compare before they trust each other.

namespace swiftgs {

/// The library's version, and a checksum of the program with the library's shared objects: ranks may have
/// been started from different files.
SWIFTGS_API std::string build_identity();

/// Size of a file, and checksum: of all of it up to 1 MiB; of a larger one, of its first and last 64 KiB and
/// of 64 blocks of 4 KiB between. It detects another scene or further training; it may miss a few numbers
/// changed by hand. Throws `FileError`.
SWIFTGS_API std::string file_identity(const std::filesystem::path& path);

/// Hash of what the views of a frame show and of the planes that they ask for. Addresses do not count.
SWIFTGS_API std::uint64_t views_identity(Span<const View> views);

}  // namespace swiftgs
