// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <memory>
#include <string>

#include <swiftgs/error.hpp>

namespace swiftgs {

/// The model of this machine's processor from /proc/cpuinfo, or "unknown processor".
inline std::string processor_name() {
  // <fstream> would include <locale>.
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen("/proc/cpuinfo", "r"), &std::fclose);
  char part[1024];
  while (file && std::fgets(part, sizeof part, file.get())) {
    std::string line = part;
    if (!line.starts_with("model name")) continue;
    if (line.back() == '\n') line.pop_back();
    const std::size_t colon = line.find(':');
    const std::size_t first = colon == std::string::npos ? colon : line.find_first_not_of(" \t", colon + 1);
    if (first == std::string::npos) break;
    return line.substr(first, line.find_last_not_of(" \t") + 1 - first);
  }
  return "unknown processor";
}

/// Throws `InvalidArgument` for a negative number of threads, of whatever backend.
inline void require_thread_count(int threads) {
  if (threads < 0) detail::refuse("backend: threads is ", threads, ", expected 1 or more, or 0 for all");
}

}  // namespace swiftgs
