// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <swiftgs/frame.hpp>
#include <swiftgs/io/image.hpp>

#include "read/views.hpp"

namespace swiftgs::cli {

/// The photograph of each view, which is one of `cameras` times `scale`, as `PhotoFolder` finds it in
/// `folder`; nothing where there is none. Empty where no view has one, or `folder` is empty. All have three
/// channels and the size of their view: colours are laid over `background` by the photograph's alpha, grey
/// becomes RGB, and of a photograph with the size of the camera each pixel gets the mean over its area. Notes
/// how many views have none, as `say_notes` does. All processes of the team call it with the same views.
/// Throws `InvalidArgument` as `PhotoFolder` does, and if one has another size, or is not the same file
/// in all processes.
std::vector<std::optional<Image>> photographs_of(const std::vector<View>& views, const Cameras& cameras,
                                                 const std::string& folder, double scale,
                                                 const vec3& background, std::vector<std::string>& said);

/// PSNR of `frame`, clamped to what a photograph can hold, against `photo`. @units{dB}
double psnr_against(const Image& photo, const Frame& frame);

}  // namespace swiftgs::cli
