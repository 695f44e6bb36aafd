// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "ply_fields.hpp"

namespace swiftgs::io {

/// What the trainer's comments say of the render model; the last one counts.
struct PlyModel {
  bool antialiased = false;
  bool flat = false;  ///< 2D Gaussians
};

PlyModel model_of(const PlyHeader& header);

/// What the scene does not carry of a file with these coefficients. `unused_scale` says whether it stores a
/// third scale though the Gaussians are `flat`.
std::vector<std::string> notes_of(bool flat, bool unused_scale, const PlySh& sh);

/// Notes the properties `unread` of elements that were read, and the elements that were not: all with rows
/// whose names are not in `read`.
void note_unread(const PlyHeader& header, const std::vector<std::string_view>& read,
                 const std::vector<std::string>& unread, std::vector<std::string>& notes);

}  // namespace swiftgs::io
