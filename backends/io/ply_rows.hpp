// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "ply_header.hpp"

/// @file
/// Rows of an element, whatever they mean.

namespace swiftgs::io {

/// The offset after all rows of `element`, which start at `position`. Throws `FormatError` if they do not
/// fit.
std::uint64_t skip_rows(const Source& source, const PlyElement& element, PlyEncoding encoding,
                        std::uint64_t position);

/// Parses one row of an ascii file, scalars only, into `row`. Returns the offset after it.
std::uint64_t parse_text_row(const Source& source, const PlyElement& element, std::uint64_t position,
                             std::vector<double>& row);

/// Throws unless the file ends at `position`, blanks after the last row of an ascii file aside.
void expect_end(const Source& source, PlyEncoding encoding, std::uint64_t position);

}  // namespace swiftgs::io
