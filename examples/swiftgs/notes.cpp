// SPDX-License-Identifier: Apache-2.0
#include "notes.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "draw/team.hpp"

namespace swiftgs::cli {

std::vector<std::string> notes_of(const std::string& file, const std::vector<std::string>& notes) {
  std::vector<std::string> named;
  for (const std::string& note : notes) named.push_back(file + ": " + note);
  return named;
}

void say_notes(const std::string& file, const std::vector<std::string>& notes,
               std::vector<std::string>& said) {
  for (std::string& line : notes_of(file, notes)) {
    if (std::find(said.begin(), said.end(), line) != said.end()) continue;
    said.push_back(std::move(line));
    if (Team::here().leads()) std::fprintf(stderr, "swiftgs: %s\n", said.back().c_str());
  }
}

}  // namespace swiftgs::cli
