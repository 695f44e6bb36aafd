// SPDX-License-Identifier: Apache-2.0
#include "stress/stress.hpp"

#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>

#include <CLI/CLI.hpp>

#include "bench/threads.hpp"
#include "commands.hpp"
#include "draw/choice.hpp"
#include "draw/team.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "result_file.hpp"
#include "stress/sweep.hpp"
#include "stress/table.hpp"

namespace swiftgs::cli {
namespace {

constexpr int most_seeds = 1000000;

constexpr const char* stress_help =
    R"(Draws frames that are hard on float arithmetic, and judges them against float64. A family is a
kind of hard frame, and its severity says how hard. The strict normalised error is a pixel's error
over what rounding the scene and the arithmetic to float may cost: up to 10 a renderer is about as
good as float can be, from 100 on it has lost digits.
A splat can lie so close to a threshold, or to the depth of another splat, that rounding decides
whether it is drawn or which is in front. Such a pixel is ambiguous, and the error that the decision
can cause is subtracted first. A rasterizer's exponent representation may be allowed an error too;
only the split representations are. The normalised error subtracts it, the strict one does not. A
warning names the renderers and families in which it may be more than 1/255 of a colour.
'ambiguity' is the largest share of a pixel's weight that such decisions and the allowed error decide.
A pixel is not judged if they decide all of it; 'judged' is the share of pixels that are.
--scene-only excuses less: what rounding the scene's own floats may cost, but not the rounding of
the means and factors that renderers store of its splats.
--search SECONDS climbs instead: it changes small frames of all families, and of lone Gaussians that
point at the camera, and keeps what is drawn worse. Where sorts differ alone, frames must be equal.
The frames follow from --seed and the renderers; how many there are depends on the time.
--severity is all, max, or numbers in the units of each family. docs/results.md describes the JSON.
Exit code 0: every normalised error is 10 or less. Exit code 1: a normalised error is above 10, a
renderer failed, or an option is wrong; the last line on standard error says which. Bounds that cut
splats, as three-sigma-square does, do not pass.

Examples:
  swiftgs stress --json stress.json
  swiftgs stress --renderers 'cuda/early/*/ellipse' --families needles,mixtures --severity max
  swiftgs stress --families needles --severity 1e3,1e5 --seeds 64 --size 64x48,960x540
  swiftgs stress --search 60 --renderers 'serial/*/per-pixel/ellipse' --json worst.json)";

/// Throws unless every renderer keeps what its exponent representation promises.
void require_promises(const std::vector<StressRow>& rows) {
  std::size_t above = 0, failed = 0;
  const StressRow *worst = nullptr, *failure = nullptr;
  for (const StressRow& row : rows) {
    if (row.failed > 0) ++failed, failure = failure ? failure : &row;
    if (row.failed == row.seeds || row.worst.normalised_error <= stress_gate) continue;
    ++above;
    if (!worst || !(row.worst.normalised_error <= worst->worst.normalised_error)) worst = &row;
  }
  const auto case_of = [](const StressRow& row) {
    return row.renderer + " on " + row.family + " at " + severity_text(row.severity);
  };
  const std::string of_rows = " of " + std::to_string(rows.size()) + " rows";
  if (failure)
    throw std::runtime_error("stress: renderers failed in " + std::to_string(failed) + of_rows + ", first " +
                             case_of(*failure) + ", " + failure->error);
  if (worst)
    throw std::runtime_error("stress: expected a normalised error up to 10; " + std::to_string(above) +
                             of_rows + " are above, the worst " + error_text(worst->worst.normalised_error) +
                             " of " + case_of(*worst));
}

}  // namespace

void stress(const StressOptions& options, const std::vector<RendererEntry>& entries) {
  if (options.search) return search(options, entries);
  const std::vector<StressPoint> points = points_of(options.families, options.severities, options.sizes);
  if (options.seeds < 1 || options.seeds > most_seeds)
    throw std::invalid_argument("--seeds " + std::to_string(options.seeds) + ": expected 1 to " +
                                std::to_string(most_seeds));
  const ThreadLimit limit(options.threads);
  ResultFile file(options.json);
  const ResultHead head = head_of("swiftgs-stress");
  std::vector<StressRow> rows;
  Sweep sweep(entries, options.seeds, limit.threads(), options.scene_only);
  {
    const Team& team = Team::here();
    Progress progress(points.size() * std::size_t(options.seeds) * entries.size());
    Numbered<StressRow> shared;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!team.takes(i)) continue;
      for (StressRow& row : sweep.run(points[i], progress)) {
        if (team.is_shared()) shared.emplace_back(i, row);
        rows.push_back(std::move(row));
      }
      if (!team.is_shared()) file.write(to_json(head, rows));
    }
    progress.await_others();
    team.join(shared);
    if (!team.leads()) return;
    if (team.is_shared()) {
      rows = rows_of(std::move(shared));
      file.write(to_json(head, rows));
    }
  }
  print_stress(rows);
  std::fflush(stdout);
  file.finish();
  require_promises(rows);
}

void add_stress(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("stress", "Where renderers stop being exact, on frames made to be hard");
  command->footer(stress_help);
  const auto options = std::make_shared<StressOptions>();
  command->add_option("--renderers", options->renderers, "Names with * for any text, separated by commas")
      ->capture_default_str();
  command->add_option("--families", options->families, "Names separated by commas [all]");
  const auto of_sweep = {
      command->add_option("--severity", options->severities, "How hard: all, max, or numbers"),
      command->add_option("--seeds", options->seeds, "How many frames of each family and severity"),
      command->add_option("--size", options->sizes, "Sizes of images, as 64x48,960x540")};
  for (CLI::Option* option : of_sweep) option->capture_default_str();
  CLI::Option* search =
      command->add_option("--search", options->search, "Climb towards worse frames, for so many seconds");
  command->add_option("--seed", options->seed, "Of the search")->capture_default_str()->needs(search);
  for (CLI::Option* option : of_sweep) search->excludes(option);
  command->add_flag("--scene-only", options->scene_only,
                    "Excuse what rounding the scene may cost, but not that of stored means and factors");
  command->add_option("--threads", options->threads, "Threads of the cpu backend and of the reference [all]");
  add_json(*command, options->json);
  command->callback([options] { stress(*options, renderers_matching(options->renderers)); });
}

}  // namespace swiftgs::cli
