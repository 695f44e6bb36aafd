// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace swiftgs::cli {

/// A file of a command and the option that names it. An empty name stands for none.
struct NamedFile {
  std::string option, name;
};

/// Whether two paths lead to the same file, which need not exist yet. Files that are not plain, such as
/// pipes, never count as the same: a pipe takes the output of both.
inline bool is_same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code none;
  const fs::file_status status = fs::status(a, none);
  if (fs::exists(status) && !fs::is_regular_file(status)) return false;
  if (fs::equivalent(a, b, none)) return true;
  const auto resolved = [&](const std::string& name) {
    fs::path absolute = fs::absolute(name, none);
    constexpr int most_links = 40;  // to a file that is not there yet
    for (int links = 0; links < most_links && fs::is_symlink(absolute, none); ++links)
      absolute = absolute.parent_path() / fs::read_symlink(absolute, none);
    const fs::path path = fs::weakly_canonical(absolute, none);
    return none ? absolute.lexically_normal() : path;
  };
  return resolved(a) == resolved(b);
}

/// Throws `InvalidArgument` where one of `outputs` is the same file as one of `inputs` or as an output
/// before it.
inline void require_distinct(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs) {
  std::vector<NamedFile> others = inputs;
  for (const NamedFile& output : outputs) {
    if (output.name.empty()) continue;
    for (const NamedFile& other : others)
      if (!other.name.empty() && is_same_file(output.name, other.name))
        throw std::invalid_argument(output.option + " " + output.name +
                                    ": expected another file than that of " + other.option +
                                    (other.name == output.name ? "" : ", " + other.name));
    others.push_back(output);
  }
}

}  // namespace swiftgs::cli
