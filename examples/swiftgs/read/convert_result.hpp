// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <swiftgs/io/scene_file.hpp>

#include "result_head.hpp"

namespace swiftgs::cli {

/// A file that was read or written.
struct ConvertedFile {
  std::string name, format;
  std::uint64_t bytes = 0;    ///< 0 of the built-in scene
  std::uint64_t stored = 0;   ///< Gaussians in a file that was read, or in the scene that was written
  std::size_t gaussians = 0;  ///< of them read or written
  int sh_degree = 0;
  std::string model;  ///< as `text_of` has it
  double seconds = 0;
};

/// What was done to the scene between reading and writing.
struct ConvertStep {
  std::string what;           ///< the option
  std::size_t gaussians = 0;  ///< after it
  int sh_degree = 0;          ///< after it
};

struct ConvertResult {
  ResultHead head;
  std::vector<ConvertedFile> inputs;
  std::vector<ConvertStep> steps;
  ConvertedFile output;
  LargestLosses losses;  ///< of writing
};

std::string to_json(const ConvertResult& result);
void print_table(const ConvertResult& result);

}  // namespace swiftgs::cli
