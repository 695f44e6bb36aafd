// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "ply_header.hpp"
#include "progress_meter.hpp"

/// @file
/// Rows of an element, whatever they mean.

namespace swiftgs::io {

/// Where rows of an element of scalars start, evenly chosen from all.
using RowSample = std::vector<std::uint64_t>;

/// Where the rows of each element start, by its name; `vertices` gets some rows of 'vertex'. Throws
/// `FormatError` unless the rows of all elements make up the rest of the file, blanks at the end of an ascii
/// file aside. Asked before memory is taken for them.
std::map<std::string, std::uint64_t> locate_rows(const Source& source, const PlyHeader& header,
                                                 const ProgressMeter& progress, RowSample& vertices);

/// Parses one row of an ascii file, scalars only, into `row`. Returns the offset after it.
std::uint64_t parse_text_row(const Source& source, const PlyElement& element, std::uint64_t position,
                             std::vector<double>& row);

}  // namespace swiftgs::io
