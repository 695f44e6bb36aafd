// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/conventions.hpp>

#include "ply_fields.hpp"

namespace swiftgs::io {

/// The rendering model that the trainer's comments name; the last comment counts. `filtered`: the vertices
/// have the 3D filter of Mip-Splatting, which trains with its 2D filter too. Adds a note for each value that
/// is not known.
RenderingModel model_of(const PlyHeader& header, bool filtered, std::vector<std::string>& notes);

/// The comments that `model_of` reads.
std::string model_comments(const RenderingModel& model);

/// What the scene does not carry of a file with these coefficients. `unused_scale`: it stores a third scale
/// of Gaussians that are flat.
std::vector<std::string> notes_of(bool unused_scale, const PlySh& sh);

/// Notes the properties `unread` of elements that were read, and the elements that were not: all with rows
/// whose names are not in `read`.
void note_unread(const PlyHeader& header, const std::vector<std::string_view>& read,
                 const std::vector<std::string>& unread, std::vector<std::string>& notes);

}  // namespace swiftgs::io
