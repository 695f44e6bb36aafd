// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <swiftgs/any_renderer.hpp>

#include "progress.hpp"
#include "stress/cases.hpp"
#include "stress/results.hpp"

namespace swiftgs::cli {

/// Draws hard frames with several renderers and judges each against float64.
class Sweep {
 public:
  /// Seeds are 1 to `seeds`; `threads` are those of the reference, 0 for all.
  Sweep(std::vector<RendererEntry> entries, int seeds, int threads);

  /// One row for each renderer. Throws only where the reference does: a renderer that throws has a row that
  /// says so, and is made anew.
  std::vector<StressRow> run(const StressPoint& point, Progress& progress);

 private:
  struct Subject {
    RendererEntry entry;
    std::unique_ptr<AnyRenderer> renderer;  ///< empty after it threw
  };
  void draw_seed(const StressPoint& point, std::uint64_t seed, std::vector<StressRow>& rows,
                 Progress& progress);

  std::vector<Subject> subjects_;
  int seeds_, threads_;
};

}  // namespace swiftgs::cli
