// SPDX-License-Identifier: Apache-2.0
#include "notes.hpp"

#include <cstdio>

#include "team.hpp"

namespace swiftgs::cli {

void say_notes(const std::string& file, const std::vector<std::string>& notes,
               std::vector<std::string>& said) {
  for (const std::string& note : notes) {
    said.push_back(file + ": " + note);
    if (Team::here().leads()) std::fprintf(stderr, "swiftgs: %s\n", said.back().c_str());
  }
}

}  // namespace swiftgs::cli
