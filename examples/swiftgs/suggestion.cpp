// SPDX-License-Identifier: Apache-2.0
#include "suggestion.hpp"

#include <algorithm>

namespace swiftgs::cli {
namespace {

/// How many characters are to be added, left out, replaced or swapped with their neighbour to make one word
/// of the other.
std::size_t edits_between(std::string_view a, std::string_view b) {
  // Rows of the table of distances between beginnings of `a` and of `b`: the last three.
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last.swap(last), last.swap(row);
  }
  return last[b.size()];
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return result;
}

}  // namespace

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
  const std::string* nearest = nullptr;
  // The dashes of an option are no letters of its name.
  const std::size_t letters = word.size() - std::min(word.find_first_not_of('-'), word.size());
  std::size_t least = 1 + letters / 3;
  for (const std::string& name : known)
    if (const std::size_t edits = edits_between(lower(word), lower(name));
        edits < least || (!nearest && edits == least))
      least = edits, nearest = &name;
  return nearest ? ", did you mean '" + *nearest + "'?" : "";
}

}  // namespace swiftgs::cli
