// SPDX-License-Identifier: Apache-2.0
#include "hard_frames/search.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "bench/threads.hpp"
#include "draw/team.hpp"
#include "notes.hpp"
#include "result_file.hpp"
#include "stress/stress.hpp"
#include "stress/sweep.hpp"
#include "stress/table.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

constexpr double longest_search = 1e6;
constexpr int steps_a_second = 10;

double checked_seconds(double seconds) {
  if (!(seconds > 0 && seconds <= longest_search))
    throw std::invalid_argument("--search " + text_of_number(seconds) +
                                ": expected seconds, above 0 and up to " + text_of_number(longest_search));
  return seconds;
}

/// A renderer of the table, made anew after it threw.
StressSubject subject_of(const RendererEntry& entry) {
  const auto renderer = std::make_shared<std::unique_ptr<AnyRenderer>>();
  return {entry.name, [entry, renderer](const StressCase& drawn) {
            std::unique_ptr<AnyRenderer> made = std::move(*renderer);
            if (!made) made = entry.make();
            Frame frame = draw(*made, drawn);
            *renderer = std::move(made);
            return frame;
          }};
}

std::vector<SearchRow> rows_of_search(const StressSearch& search) {
  std::vector<SearchRow> rows;
  for (std::size_t i = 0; i < search.subjects().size(); ++i)
    for (std::size_t family = 0; family < search.families().size(); ++family)
      for (const StressSearch::Plane plane : {StressSearch::colour, StressSearch::depth}) {
        const StressFind& worst = search.worst(i, plane, family);
        rows.push_back({.renderer = search.subjects()[i].name,
                        .family = std::string(search.families()[family].name),
                        .plane = plane == StressSearch::colour ? "colour" : "depth",
                        .tries = search.tries(),
                        .normalised_error = worst.normalised_error,
                        .error = worst.error});
      }
  return rows;
}

/// The worse of every row that several processes have.
void join(std::vector<SearchRow>& rows) {
  const Team& team = Team::here();
  if (!team.is_shared()) return;
  Numbered<SearchRow> shared;
  for (std::size_t i = 0; i < rows.size(); ++i) shared.emplace_back(i, std::move(rows[i]));
  team.join(shared);
  rows.clear();
  for (auto& [number, row] : shared) {
    if (number == rows.size()) {
      rows.push_back(std::move(row));
      continue;
    }
    SearchRow& known = rows[number];
    const std::uint64_t tries = known.tries + row.tries;
    if (row.normalised_error > known.normalised_error) known = std::move(row);
    known.tries = tries;
  }
}

/// Climbs until `seconds` are over.
void climb(StressSearch& search, double seconds) {
  Progress progress(std::size_t(std::ceil(seconds * steps_a_second)));
  const auto begun = std::chrono::steady_clock::now();
  for (std::size_t step = 0;;) {
    search.try_one();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begun;
    if (elapsed.count() >= seconds) break;
    if (const auto now = std::size_t(elapsed.count() * steps_a_second); now > step) {
      progress.advance_to(step = now);
      progress.start(std::to_string(search.tries()) + " frames");
    }
  }
  progress.await_others();
}

void require_promises(const std::vector<SearchRow>& rows) {
  const SearchRow* worst = nullptr;
  std::size_t above = 0;
  for (const SearchRow& row : rows) {
    above += row.normalised_error > stress_gate;
    if (!worst || row.normalised_error > worst->normalised_error) worst = &row;
  }
  if (above == 0) return;
  throw std::runtime_error("stress: expected a normalised error up to 10; " + std::to_string(above) + " of " +
                           std::to_string(rows.size()) + " rows are above, the worst " +
                           error_text(worst->normalised_error) + " of " + worst->renderer + " on " +
                           worst->family + (worst->error.empty() ? "" : ": " + worst->error));
}

}  // namespace

void search(const StressOptions& options, const std::vector<RendererEntry>& entries) {
  const double seconds = checked_seconds(*options.search);
  std::vector<StressFamily> families;
  for (const StressFamily* family : families_named(options.families, search_families()))
    families.push_back(*family);
  const ThreadLimit limit(options.threads);
  ResultFile file(options.json);
  const ResultHead head = head_of("swiftgs-stress-search");

  std::vector<StressSubject> subjects;
  for (const RendererEntry& entry : entries) subjects.push_back(subject_of(entry));
  const Team& team = Team::here();
  StressSearch found(std::move(subjects), std::move(families),
                     options.seed * std::uint64_t(team.size()) + std::uint64_t(team.rank()),
                     options.scene_only);
  climb(found, seconds);
  std::vector<SearchRow> rows = rows_of_search(found);
  join(rows);
  if (!team.leads()) return;
  file.write(to_json(head, rows));
  print_search(rows);
  std::fflush(stdout);
  file.finish();
  require_promises(rows);
}

}  // namespace swiftgs::cli
