// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bench/machine.hpp"

/// What the result files of all commands have in common, as docs/schemas/common.schema.json says.
namespace swiftgs::cli {

/// Kind of the results, the machine and the command that made them, and notes about their files.
struct ResultHead {
  std::string format;
  Machine machine;
  std::string command;
  std::vector<std::string> notes{};  ///< as `say_notes` says them
};

/// The head of the results of this run.
ResultHead head_of(std::string_view format);

/// A member of a JSON object: its name, and its value as JSON.
using Member = std::pair<std::string, std::string>;

/// A result file: an object that begins with `head`.
std::string document_of(const ResultHead& head, const std::vector<Member>& members);

/// An array, one element a line.
std::string array_of(const std::vector<std::string>& elements);

/// The same of `values`, as `json_of` turns them to text.
template <class Values, class JsonOf>
std::string array_of(const Values& values, JsonOf json_of) {
  std::vector<std::string> elements;
  for (const auto& value : values) elements.push_back(json_of(value));
  return array_of(elements);
}

}  // namespace swiftgs::cli
