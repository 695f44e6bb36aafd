// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "bytes.hpp"

namespace swiftgs::io {

/// A camera model of COLMAP that can be rendered.
struct ColmapModel {
  int parameters;  ///< how many follow the size
};

/// The model with COLMAP's number `id`. Throws `FormatError` that names any model with distortion.
ColmapModel colmap_model(const Source& source, std::uint64_t offset, std::int32_t id);

/// The model called `name`, likewise.
ColmapModel colmap_model(const Source& source, std::uint64_t offset, std::string_view name);

/// Throws `FormatError` that names what was found in place of such a model.
[[noreturn]] void refuse_model(const Source& source, std::uint64_t offset, std::string_view found);

}  // namespace swiftgs::io
