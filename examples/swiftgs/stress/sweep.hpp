// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/stress.hpp>

#include "hard_frames/families.hpp"
#include "notes.hpp"
#include "result_head.hpp"

namespace swiftgs::cli {

/// A family at one severity and image size.
struct StressPoint {
  const StressFamily* family = nullptr;
  double severity = 0;
  ImageSize size;
};

/// The families that `names` lists, in their order; all if it is empty. Throws `InvalidArgument` with the
/// valid names.
std::vector<const StressFamily*> families_named(const std::string& names,
                                                const std::vector<StressFamily>& families);

/// Every combination, size by size such as `64x48,960x540`, and family by family. `severities` is `max`,
/// `all` or numbers. Throws `InvalidArgument`.
std::vector<StressPoint> points_of(const std::string& families, const std::string& severities,
                                   const std::string& sizes);

/// As 1e10, 0.1 or inf.
std::string severity_text(double severity);

/// A renderer is not trusted if its strict normalised error is above this. It breaks the promise of its
/// exponent representation if its normalised error is.
inline constexpr double stress_gate = 10;

/// One renderer on a family at one severity and image size.
struct StressRow {
  std::string family, severity_label;
  double severity = 0;
  int width = 0, height = 0;
  std::string renderer;
  int seeds = 0;        ///< that were drawn or tried
  int failed = 0;       ///< of these, where the renderer threw
  StressVerdict worst;  ///< over the seeds; of `flips` the sum, of `judged` and `psnr_db` the least
  std::uint64_t worst_seed = 0;
  std::string error;  ///< first message of the renderer, or empty

  static auto members(auto& self) {
    auto& w = self.worst;
    return std::tie(self.family, self.severity_label, self.severity, self.width, self.height, self.renderer,
                    self.seeds, self.failed, w.strict_normalised_error, w.normalised_error,
                    w.normalised_depth_error, w.psnr_db, w.max_abs, w.ambiguity, w.allowed, w.judged, w.flips,
                    self.worst_seed, w.worst_pixel, self.error);
  }
  /// Whether every seed was drawn about as exactly as floats can. NaN is not.
  bool is_exact() const { return failed == 0 && worst.strict_normalised_error <= stress_gate; }
  /// Whether the exponent representation may err by more than a picture of 8 bits hides.
  bool may_show() const { return worst.allowed > 1.0 / 255; }
};

/// The document of `--json`.
std::string to_json(const ResultHead& head, const std::vector<StressRow>& rows);

/// Draws `made`, which no occluder hides.
Frame draw(AnyRenderer& renderer, const StressCase& made);

/// Draws hard frames with several renderers and judges each against float64.
class Sweep {
 public:
  /// Seeds are 1 to `seeds`; `threads` are those of the reference, 0 for all; `scene_only` as of
  /// `StressTrials`.
  Sweep(std::vector<RendererEntry> entries, int seeds, int threads, bool scene_only = false);

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
  bool scene_only_;
};

}  // namespace swiftgs::cli
