// SPDX-License-Identifier: Apache-2.0
#include "bench/lists.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "number_text.hpp"

namespace swiftgs::cli {
namespace {

template <class Number>
std::vector<Number> parsed(const std::string& option, const std::string& text, const char* expected) {
  std::vector<Number> numbers;
  for (const std::string& part : list_of(option, text)) {
    const std::optional<Number> number = parse<Number>(part);
    if (!number)
      throw std::invalid_argument(option + " '" + text + "': expected " + expected + " separated by commas");
    if (std::find(numbers.begin(), numbers.end(), *number) != numbers.end())
      throw std::invalid_argument(option + " '" + text + "': expected every value once");
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

std::vector<std::string> list_of(const std::string& option, const std::string& text) {
  const std::vector<std::string_view> split_text = split(text, ',');
  const std::vector<std::string> parts(split_text.begin(), split_text.end());
  if (std::any_of(parts.begin(), parts.end(), [](const std::string& part) { return part.empty(); }))
    throw std::invalid_argument(option + " '" + text + "': expected values separated by commas");
  for (auto part = parts.begin(); part != parts.end(); ++part)
    if (std::find(parts.begin(), part, *part) != part)
      throw std::invalid_argument(option + " '" + text + "': expected every value once");
  return parts;
}

std::vector<double> numbers_of(const std::string& option, const std::string& text) {
  return parsed<double>(option, text, "numbers");
}

std::vector<std::size_t> counts_of(const std::string& option, const std::string& text) {
  return parsed<std::size_t>(option, text, "whole numbers");
}

}  // namespace swiftgs::cli
