// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace swiftgs::cli {

/// `notes` as results list them, behind the name of their file.
std::vector<std::string> notes_of(const std::string& file, const std::vector<std::string>& notes);

/// Says on standard error what a reader or a writer notes of `file`, a line for each note, and adds the lines
/// to `said`, which `ResultHead::notes` takes. A line that is there already is not said again. Of several
/// processes the first says it.
void say_notes(const std::string& file, const std::vector<std::string>& notes,
               std::vector<std::string>& said);

}  // namespace swiftgs::cli
