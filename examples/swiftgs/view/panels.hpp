// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the viewer shows before the picture, and its controls. Each panel sets `changed` where a new frame is
/// needed.

#include <string>
#include <vector>

#include <swiftgs/frame/math.hpp>

#include "view/viewer.hpp"

namespace swiftgs::cli {

/// Opens the list below a box of `shown`; `EndCombo` ends it where this returns true. `escape` closes it, and
/// is false then.
bool begin_list(const char* label, const std::string& shown, bool& escape);

/// An entry of a list, with any name. Returns whether it was chosen. `number` tells equal names apart.
bool list_entry(std::size_t number, const std::string& name, bool is_chosen);

/// Lists `words` to choose one of. Returns whether `chosen` changed.
bool choose(const char* label, const std::vector<std::string>& words, std::string& chosen, bool& escape);

/// Three numbers to drag, `step` a pixel, with the digits that show a step. Returns whether they changed.
bool drag(const char* label, dvec3& values, double step);

/// Keeps typed numbers between `low` and `high` too. Returns whether `value` changed.
bool slide(const char* label, double& value, double low, double high, const char* format, bool logarithmic);

/// `part` of `whole` as a bar with a text.
void bar(const char* label, double part, double whole, const std::string& text);

/// Digits of `value` that tell it from `value + step`, 3 or more.
int digits_of(double value, double step);

std::string text_of(const char* format, double number);

/// The end of `text` that is at most `width` wide, behind dots where that is not all.
std::string end_within(const std::string& text, float width);

/// Shows `whole` beside the mouse over the last item, if the item shows less, which is `shown`.
void tell_whole(const std::string& whole, const std::string& shown);

/// Draws the panels and applies their changes. Returns whether a new frame is needed.
bool draw_panels(Viewer& viewer);

/// The list of scenes: edits how each is placed and shown, and saves the list.
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
