// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "view/viewer.hpp"

/// @file
/// What the viewer shows before the picture. Each panel sets `changed` where a new frame is needed.

namespace swiftgs::cli {

/// Draws the panels and applies their changes. Returns whether a new frame is needed.
bool draw_panels(Viewer& viewer);

/// The list of scenes: where they stand, what of them shows, and where the list is saved.
void scene_panel(Viewer& viewer, bool& changed);

/// Draws the messages, of which the user dismisses errors.
void draw_messages(Viewer& viewer);

/// Draws what the colours of depths mean, where the picture shows depths.
void draw_legend(const Viewer& viewer);

/// Marks the crop that is compared, and the Gaussian that was picked.
void draw_marks(const Viewer& viewer);

/// Asks whether to leave what is not saved, while `viewer` is asked to quit.
void ask_to_quit(Viewer& viewer);

}  // namespace swiftgs::cli
