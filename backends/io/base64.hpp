// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

#include "progress_meter.hpp"

namespace swiftgs::io {

/// Bytes that `text` stands for, in the standard alphabet, with or without padding; 0 if no bytes have such a
/// length.
std::size_t base64_size(std::string_view text);

/// Decodes `text` to `base64_size(text)` bytes on all cores. Returns the position of a character that is not
/// of the alphabet, or npos.
std::size_t decode_base64(std::string_view text, std::byte* to, const ProgressMeter& progress);

}  // namespace swiftgs::io
