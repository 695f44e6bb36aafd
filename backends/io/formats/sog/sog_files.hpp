// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mapped_file.hpp"

/// @file
/// The files that make up a SOG: `meta.json` and the images that it names.

namespace swiftgs::io {

struct SogFile {
  Source source;
  std::uint64_t stored = 0;             ///< bytes that it takes on the disk
  FileIdentity identity{};              ///< of what takes them
  std::shared_ptr<const void> owner{};  ///< of `source`'s bytes, which are valid as long as it
};

/// Opens a file by its name. Throws `FormatError` or `FileError` if it is not there.
using SogFiles = std::function<SogFile(const std::string& name)>;

/// The entries of a bundle, a ZIP archive, which must outlive what this returns. An entry unpacks to at most
/// 16 times its packed size and 64 KiB more: images do not compress further, and `meta.json` is small.
/// Entries take no bytes of their own: theirs are the bundle's, and may overlap in it.
SogFiles files_of_bundle(const Source& bundle);

/// The names of the entries of a ZIP archive; none where they cannot be listed.
std::vector<std::string> names_in_bundle(std::string_view archive);

/// The files beside `meta`, which must outlive what this returns. Throws `FormatError` if it comes from
/// memory, where nothing lies beside it.
SogFiles files_beside(const Source& meta);

/// The files beside `name`, which `files` opens.
SogFiles files_beside(const std::string& name, const SogFiles& files);

/// Whether a name leads to a file of the folder that it is looked up in, or of a folder therein.
bool stays_inside(const std::string& name);

}  // namespace swiftgs::io
