// SPDX-License-Identifier: Apache-2.0

#include "stress/table.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include "json.hpp"
#include "stress/sweep.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

using Rows = std::vector<const StressRow*>;

/// `rows` in groups with the same key, groups and rows in the order in which they come.
template <class Key>
std::vector<Rows> grouped(const Rows& rows, Key key) {
  std::vector<Rows> groups;
  for (const StressRow* row : rows) {
    const auto found = std::find_if(groups.begin(), groups.end(),
                                    [&](const Rows& group) { return key(*group.front()) == key(*row); });
    if (found == groups.end())
      groups.push_back({row});
    else
      found->push_back(row);
  }
  return groups;
}

std::string renderer_of(const StressRow& row) { return row.renderer; }
std::string family_of(const StressRow& row) { return row.family; }

/// One renderer on a family: rows of ascending severity.
void print_line(const Rows& rows) {
  const StressRow& last = *rows.back();
  std::string exact = "-";
  for (const StressRow* row : rows) {
    if (!row->is_exact() || row->worst.judged == 0) break;
    exact = severity_text(row->severity);
  }
  const StressVerdict& worst = last.worst;
  std::printf("  %-62s %8s ", last.renderer.c_str(), exact.c_str());
  if (last.failed == last.seeds) {
    std::printf("  failed\n");
    return;
  }
  // What is not judged has no error that says anything.
  std::printf("%9s %8.1e %5.0f dB %9.2g %7.1f%%\n",
              worst.judged > 0 ? error_text(worst.strict_normalised_error).c_str() : "-", worst.max_abs,
              worst.psnr_db, worst.ambiguity, std::floor(1000 * worst.judged) / 10);
}

/// All renderers on a family, on images of one size.
void print_family(const Rows& rows) {
  const StressRow& last = *rows.back();
  std::printf("\n%-64s %8s %9s %8s %8s %9s %8s\n",
              (last.family + ", " + last.severity_label + " up to " + severity_text(last.severity) + ": " +
               std::to_string(last.width) + "x" + std::to_string(last.height) + ", " +
               std::to_string(last.seeds) + (last.seeds == 1 ? " seed" : " seeds"))
                  .c_str(),
              "exact to", "error", "largest", "PSNR", "ambiguity", "judged");
  for (const Rows& renderer : grouped(rows, renderer_of)) print_line(renderer);
}

/// From where on one renderer loses digits, in a line.
void print_verdict(const Rows& rows) {
  const StressRow *worst = nullptr, *most_ambiguous = nullptr;
  std::string stops;
  std::size_t families = 0;
  for (const Rows& family : grouped(rows, family_of)) {
    ++families;
    const auto bad =
        std::find_if(family.begin(), family.end(), [](const StressRow* row) { return !row->is_exact(); });
    if (bad != family.end())
      stops += (stops.empty() ? "loses digits from " : ", ") + (*bad)->family + " " +
               severity_text((*bad)->severity);
  }
  for (const StressRow* row : rows) {
    if (row->failed == row->seeds) continue;
    if (!worst || !(row->worst.strict_normalised_error <= worst->worst.strict_normalised_error)) worst = row;
    if (!most_ambiguous || row->worst.ambiguity > most_ambiguous->worst.ambiguity) most_ambiguous = row;
  }
  if (stops.empty())
    stops = "exact in " + std::to_string(families) + (families == 1 ? " family" : " families");
  std::printf("%s: %s", rows.front()->renderer.c_str(), stops.c_str());
  if (worst)
    std::printf("; worst strict normalised error %s (%s %s, seed %llu); ambiguity up to %.2g (%s %s)",
                error_text(worst->worst.strict_normalised_error).c_str(), worst->family.c_str(),
                severity_text(worst->severity).c_str(), static_cast<unsigned long long>(worst->worst_seed),
                most_ambiguous->worst.ambiguity, most_ambiguous->family.c_str(),
                severity_text(most_ambiguous->severity).c_str());
  std::printf("\n");
}

/// From where on the exponent representation of one renderer is allowed errors that show, in a line.
void print_warning(const Rows& rows) {
  std::string shown;
  for (const Rows& family : grouped(rows, family_of)) {
    const auto first =
        std::find_if(family.begin(), family.end(), [](const StressRow* row) { return row->may_show(); });
    if (first == family.end()) continue;
    char weight[32];
    std::snprintf(weight, sizeof weight, " (%.2g)", (*first)->worst.allowed);
    shown +=
        (shown.empty() ? "" : ", ") + (*first)->family + " " + severity_text((*first)->severity) + weight;
  }
  if (!shown.empty())
    std::printf(
        "warning: %s: its exponent representation may err by more than 1/255 of a colour from %s; "
        "expected less\n",
        rows.front()->renderer.c_str(), shown.c_str());
}

constexpr const char* legend = R"(
'exact to' is the largest severity up to which the strict normalised error stays at or below 10 ('-': none).
The rest is of the greatest severity: the worst strict normalised error, the largest absolute error, the
least PSNR, the largest weight that the exponent representation leaves open, of 1 in a pixel, and the least
share of pixels of which it leaves less than all open: the others are not judged.
)";

}  // namespace

std::string error_text(double error) {
  if (error == 0) return "0";
  if (!std::isfinite(error)) return "inf";
  char text[32];
  std::snprintf(text, sizeof text, error < 10 ? "%.2f" : error < 1e5 ? "%.0f" : "%.1e", error);
  return text;
}

void print_stress(const std::vector<StressRow>& rows) {
  Rows all;
  for (const StressRow& row : rows) all.push_back(&row);
  const auto size_of = [](const StressRow& row) { return std::pair(row.width, row.height); };
  for (const Rows& one : grouped(all, size_of)) {
    for (const Rows& family : grouped(one, family_of)) print_family(family);
    std::printf("\n");
    for (const Rows& renderer : grouped(one, renderer_of)) print_verdict(renderer);
    for (const Rows& renderer : grouped(one, renderer_of)) print_warning(renderer);
  }
  std::printf("%s", legend);
  for (const StressRow& row : rows)
    if (row.failed > 0)
      std::printf("failed: %s on %s %s, %dx%d, %d of %d seeds: %s\n", row.renderer.c_str(),
                  row.family.c_str(), severity_text(row.severity).c_str(), row.width, row.height, row.failed,
                  row.seeds, row.error.c_str());
}

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
