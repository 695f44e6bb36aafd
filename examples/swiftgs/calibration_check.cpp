// SPDX-License-Identifier: Apache-2.0
#include "calibration_check.hpp"

#include <cmath>
#include <cstdio>
#include <utility>

#include "json_text.hpp"
#include "progress.hpp"
#include "renderer_words.hpp"
#include "scene_input.hpp"
#include "sort_timing.hpp"

namespace swiftgs::cli {
namespace {

constexpr int turns_a_view = 7;

/// How much longer the choice took than the better of both, as a part of that, and the standard error of it
/// over the views.
struct Regret {
  double part = 0, error = 0;
};

Regret regret_of(const std::vector<double>& standard, const std::vector<double>& early,
                 const std::vector<double>& adaptive) {
  const std::vector<double>& best = mean_of(early) <= mean_of(standard) ? early : standard;
  std::vector<double> longer;
  for (std::size_t i = 0; i < best.size(); ++i) longer.push_back(adaptive[i] - best[i]);
  return {mean_of(longer) / mean_of(best),
          spread_of(longer) / std::sqrt(double(longer.size())) / mean_of(best)};
}

}  // namespace

CalibrationCheck::CalibrationCheck(const std::string& json, const SceneOptions& scene,
                                   std::vector<std::string> notes)
    : file_(json),
      head_(json.empty() ? ResultHead() : head_of("swiftgs-calibration-check")),
      scene_(builtin_size(scene.scene) ? "builtin" : capture_of(scene).name) {
  head_.notes = std::move(notes);
}

void CalibrationCheck::run(const SortTrio& sorts, const std::vector<View>& views,
                           const RenderSettings& settings, std::size_t gaussians) {
  Progress progress(views.size());
  const std::vector<FrameTimes> times =
      time_in_turn({sorts.standard, sorts.early, sorts.adaptive}, views, settings, turns_a_view, progress);
  progress.clear();
  const FrameTimes &standard = times[0], &early = times[1], &adaptive = times[2];
  const Regret frame = regret_of(standard.total, early.total, adaptive.total);
  const Regret sort = regret_of(standard.sort, early.sort, adaptive.sort);
  std::printf("  check    %zu %s: standard %.3f ms (sort %.3f), early %.3f (%.3f), adaptive %.3f (%.3f)\n",
              views.size(), views.size() == 1 ? "view" : "views", mean_of(standard.total),
              mean_of(standard.sort), mean_of(early.total), mean_of(early.sort), mean_of(adaptive.total),
              mean_of(adaptive.sort));
  std::printf("  regret   %.2f +- %.2f %% of the frame, %.2f +- %.2f %% of the sort\n", 100 * frame.part,
              100 * frame.error, 100 * sort.part, 100 * sort.error);
  std::fflush(stdout);

  const RendererWords words(sorts.adaptive->name());
  const auto chosen = sorts.adaptive->calibration();
  const Json row{{"scene", scene_},
                 {"gaussians", gaussians},
                 {"width", views.front().camera.width},
                 {"height", views.front().camera.height},
                 {"device", sorts.adaptive->device_name()},
                 {"backend", words.backend},
                 {"bounds", words.bounds},
                 {"views", views.size()},
                 {"standard_ms", mean_of(standard.total)},
                 {"early_ms", mean_of(early.total)},
                 {"adaptive_ms", mean_of(adaptive.total)},
                 {"choice", chosen ? Json(chosen->prefers_early() ? "early" : "standard") : Json()},
                 {"regret", frame.part},
                 {"regret_error", frame.error},
                 {"standard_sort_ms", mean_of(standard.sort)},
                 {"early_sort_ms", mean_of(early.sort)},
                 {"adaptive_sort_ms", mean_of(adaptive.sort)},
                 {"sort_regret", sort.part},
                 {"sort_regret_error", sort.error}};
  rows_.push_back(text_of(row));
  file_.write(document_of(head_, {{"rows", array_of(rows_)}}));
}

}  // namespace swiftgs::cli
