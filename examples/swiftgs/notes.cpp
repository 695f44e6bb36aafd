// SPDX-License-Identifier: Apache-2.0
#include "notes.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "team.hpp"

namespace swiftgs::cli {

void say_notes(const std::string& file, const std::vector<std::string>& notes,
               std::vector<std::string>& said) {
  for (const std::string& note : notes) {
    std::string line = file + ": " + note;
    if (std::find(said.begin(), said.end(), line) != said.end()) continue;
    said.push_back(std::move(line));
    if (Team::here().leads()) std::fprintf(stderr, "swiftgs: %s\n", said.back().c_str());
  }
}

}  // namespace swiftgs::cli
