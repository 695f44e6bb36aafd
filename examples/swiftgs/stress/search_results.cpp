// SPDX-License-Identifier: Apache-2.0
#include "stress/search_results.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdio>

#include "draw/renderer_words.hpp"
#include "json_text.hpp"
#include "stress/table.hpp"

namespace swiftgs::cli {
namespace {

Json json_of(const SearchRow& row) {
  const RendererWords words(row.renderer);
  return {{"family", row.family},
          {"renderer", row.renderer},
          {"backend", words.backend},
          {"sort", words.sort},
          {"raster", words.raster},
          {"bounds", words.bounds},
          {"plane", row.plane},
          {"tries", row.tries},
          {"normalised_error", row.normalised_error},
          {"error", row.error.empty() ? Json() : Json(row.error)}};
}

}  // namespace

std::string to_json(const ResultHead& head, const std::vector<SearchRow>& rows) {
  return document_of(head,
                     {{"rows", array_of(rows, [](const SearchRow& row) { return text_of(json_of(row)); })}});
}

void print_search(const std::vector<SearchRow>& rows) {
  constexpr std::size_t most_shown = 5;
  for (std::size_t begin = 0, end = 0; begin < rows.size(); begin = end) {
    const std::string& renderer = rows[begin].renderer;
    std::vector<const SearchRow*> shown;
    for (; end < rows.size() && rows[end].renderer == renderer; ++end) shown.push_back(&rows[end]);
    std::stable_sort(shown.begin(), shown.end(), [](const SearchRow* a, const SearchRow* b) {
      return a->normalised_error > b->normalised_error;
    });
    std::printf("%s%s: worst normalised error %s in %llu frames\n", begin > 0 ? "\n" : "", renderer.c_str(),
                error_text(shown.front()->normalised_error).c_str(),
                static_cast<unsigned long long>(rows[begin].tries));
    shown.resize(std::min(shown.size(), most_shown));
    for (const SearchRow* row : shown)
      std::printf("  %10s of %-6s from %s%s%s\n", error_text(row->normalised_error).c_str(),
                  row->plane.c_str(), row->family.c_str(), row->error.empty() ? "" : ": ",
                  row->error.c_str());
  }
}

}  // namespace swiftgs::cli
