// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include <swiftgs/api.hpp>
#include <swiftgs/conventions.hpp>

/// @file
/// Rendering models as text, in files and on the command line: `antialiased=yes,blur=0.1`.

namespace swiftgs {

/// What of `model` is not as a scene has it that says nothing; empty if nothing is.
SWIFTGS_API std::string text_of(const RenderingModel& model);

/// `model` changed by such a text: settings with commas between, of `antialiased` (yes, no), `blur`
/// (@units{pixels^2}, 0 or more), `order` (depth, distance), `colours` (srgb, linear) and `kernel`
/// (ellipsoid, disk). Throws `InvalidArgument` that names the first setting that is none of these.
SWIFTGS_API RenderingModel model_from(std::string_view text, RenderingModel model = {});

}  // namespace swiftgs
