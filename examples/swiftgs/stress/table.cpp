// SPDX-License-Identifier: Apache-2.0
#include "stress/table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "draw/renderer_words.hpp"
#include "stress/cases.hpp"

namespace swiftgs::cli {
namespace {

using Rows = std::vector<const StressRow*>;

constexpr int first_width = 36, width = 16;

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

/// A number of a row, or "failed" where no seed was drawn.
std::string number(const StressRow& row, const char* format, double value) {
  if (row.failed == row.seeds) return "failed";
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// The largest severity up to which a renderer is exact, of its rows in ascending order; "-" for none.
std::string exact_up_to(const Rows& rows) {
  std::string severity = "-";
  for (const StressRow* row : rows) {
    if (!row->is_exact() || row->judged == 0) break;
    severity = severity_text(row->severity);
  }
  return severity;
}

/// How much of a pixel is open or, where that is all of some, how much of the image is judged.
std::string openness(const StressRow& row) {
  if (row.judged < 1) return number(row, "judged %.1f%%", std::floor(1000 * row.judged) / 10);
  return number(row, "ambiguity %.2g", row.ambiguity);
}

/// The three lines of a cell: rows of one renderer on one family.
std::vector<std::string> cell_of(const Rows& rows) {
  const StressRow& last = *rows.back();
  const std::string error = last.failed == last.seeds ? "failed"
                            : last.judged > 0         ? error_text(last.strict_normalised_error)
                                                      : "not judged";
  return {exact_up_to(rows) + "  " + error,
          number(last, "%.1e", last.max_abs) + " " + number(last, "%.0f dB", last.psnr_db), openness(last)};
}

/// The lines of a column's heading: a rasterizer's name in parts that fit.
std::vector<std::string> heading_of(std::string_view raster) {
  std::vector<std::string> lines;
  for (const std::string_view prefix : {"axis-shared-", "threshold-"})
    if (raster.starts_with(prefix)) {
      lines.emplace_back(prefix);
      raster.remove_prefix(prefix.size());
    }
  lines.emplace_back(raster);
  lines.resize(std::max<std::size_t>(3, lines.size()));
  return lines;
}

/// Prints columns of `count` lines side by side.
void print_lines(const std::vector<std::string>& first,
                 const std::vector<std::vector<std::string>>& columns) {
  for (std::size_t line = 0; line < first.size(); ++line) {
    std::string text = first[line];
    std::size_t end = first_width;
    for (const std::vector<std::string>& column : columns) {
      text.resize(std::max(end, text.size() + 1), ' ');
      text += column[line];
      end += width;
    }
    text.resize(text.find_last_not_of(' ') + 1);
    std::printf("%s\n", text.c_str());
  }
}

std::string renderer_of(const StressRow& row) { return row.renderer; }

/// One block: renderers that differ in the rasterizer alone, on images of one size.
void print_block(const Rows& rows) {
  const StressRow& any = *rows.front();
  const RendererWords words(any.renderer);
  std::printf("\n%s/%s/*/%s: %dx%d, %d %s\n\n", words.backend.c_str(), words.sort.c_str(),
              words.bounds.c_str(), any.width, any.height, any.seeds, any.seeds == 1 ? "seed" : "seeds");
  std::vector<std::vector<std::string>> headings;
  for (const Rows& column : grouped(rows, renderer_of))
    headings.push_back(heading_of(RendererWords(column.front()->renderer).raster));
  print_lines({"family", "  what its severity is", "  the greatest severity"}, headings);
  for (const Rows& family : grouped(rows, [](const StressRow& row) { return row.family; })) {
    std::vector<std::vector<std::string>> cells;
    for (const Rows& column : grouped(family, renderer_of)) cells.push_back(cell_of(column));
    const StressRow& last = *family.back();
    print_lines(
        {last.family, "  " + last.severity_label, std::string("  at ").append(severity_text(last.severity))},
        cells);
  }
}

/// From where on one renderer loses digits, in a line.
void print_verdict(const Rows& rows) {
  const StressRow *worst = nullptr, *most_ambiguous = nullptr;
  std::string stops;
  std::size_t families = 0;
  for (const Rows& family : grouped(rows, [](const StressRow& row) { return row.family; })) {
    ++families;
    const auto bad =
        std::find_if(family.begin(), family.end(), [](const StressRow* row) { return !row->is_exact(); });
    if (bad != family.end())
      stops += (stops.empty() ? "loses digits from " : ", ") + (*bad)->family + " " +
               severity_text((*bad)->severity);
  }
  for (const StressRow* row : rows) {
    if (row->failed == row->seeds) continue;
    if (!worst || !(row->strict_normalised_error <= worst->strict_normalised_error)) worst = row;
    if (!most_ambiguous || row->ambiguity > most_ambiguous->ambiguity) most_ambiguous = row;
  }
  if (stops.empty())
    stops = "exact in " + std::to_string(families) + (families == 1 ? " family" : " families");
  std::printf("%s: %s", rows.front()->renderer.c_str(), stops.c_str());
  if (worst)
    std::printf("; worst strict normalised error %s (%s %s, seed %llu); ambiguity up to %.2g (%s %s)",
                error_text(worst->strict_normalised_error).c_str(), worst->family.c_str(),
                severity_text(worst->severity).c_str(), static_cast<unsigned long long>(worst->worst_seed),
                most_ambiguous->ambiguity, most_ambiguous->family.c_str(),
                severity_text(most_ambiguous->severity).c_str());
  std::printf("\n");
}

/// From where on the exponent representation of one renderer is allowed errors that show, in a line.
void print_warning(const Rows& rows) {
  std::string shown;
  for (const Rows& family : grouped(rows, [](const StressRow& row) { return row.family; })) {
    const auto first =
        std::find_if(family.begin(), family.end(), [](const StressRow* row) { return row->may_show(); });
    if (first == family.end()) continue;
    char weight[32];
    std::snprintf(weight, sizeof weight, " (%.2g)", (*first)->allowed);
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
A cell: the largest severity up to which the strict normalised error stays at or below 10 ('-': none) and, at
the greatest severity, the worst one; the largest absolute error and the least PSNR; 'ambiguity', the largest
weight that the exponent representation leaves open, of 1 in a pixel. Where ties and thresholds leave all of
a pixel open, the pixel is not judged; 'judged' is the share of the others in the worst frame.
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
  const auto block = [](const StressRow& row) {
    const RendererWords words(row.renderer);
    return words.backend + "/" + words.sort + "/" + words.bounds + "/" + std::to_string(row.width) + "x" +
           std::to_string(row.height);
  };
  for (const Rows& one : grouped(all, block)) {
    print_block(one);
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

}  // namespace swiftgs::cli
