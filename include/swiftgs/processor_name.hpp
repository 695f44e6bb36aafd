// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <string>

namespace swiftgs {

/// The model of this machine's processor, as /proc/cpuinfo has it; "unknown processor" where it does not.
inline std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(':');
    const std::size_t first = colon == std::string::npos ? colon : line.find_first_not_of(" \t", colon + 1);
    if (first == std::string::npos) break;
    return line.substr(first, line.find_last_not_of(" \t") + 1 - first);
  }
  return "unknown processor";
}

}  // namespace swiftgs
