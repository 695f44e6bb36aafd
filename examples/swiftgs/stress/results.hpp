// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "result_head.hpp"

/// What `stress` finds, as docs/schemas/stress.schema.json describes it.
namespace swiftgs::cli {

/// A renderer is not trusted if its strict normalised error is above this. It breaks the promise of its
/// exponent representation if its normalised error is.
inline constexpr double stress_gate = 10;

/// One renderer on a family at one severity and image size: the worst over the seeds.
struct StressRow {
  std::string family, severity_label;
  double severity = 0;
  int width = 0, height = 0;
  std::string renderer;
  int seeds = 0;   ///< that were drawn or tried
  int failed = 0;  ///< of these, where the renderer threw

  double strict_normalised_error = 0, normalised_error = 0, normalised_depth_error = 0, psnr_db = 0,
         max_abs = 0, ambiguity = 0;
  double allowed = 0;       ///< as in `StressVerdict`
  double judged = 1;        ///< least share of pixels that are judged, as in `StressVerdict`
  std::uint64_t flips = 0;  ///< sum over the seeds
  std::uint64_t worst_seed = 0;
  std::size_t worst_pixel = 0;
  std::string error;  ///< first message of the renderer, or empty

  static auto members(auto& self) {
    return std::tie(self.family, self.severity_label, self.severity, self.width, self.height, self.renderer,
                    self.seeds, self.failed, self.strict_normalised_error, self.normalised_error,
                    self.normalised_depth_error, self.psnr_db, self.max_abs, self.ambiguity, self.allowed,
                    self.judged, self.flips, self.worst_seed, self.worst_pixel, self.error);
  }
  /// Whether every seed was drawn about as exactly as floats can. NaN is not.
  bool is_exact() const { return failed == 0 && strict_normalised_error <= stress_gate; }
  /// Whether the exponent representation may err by more than a picture of 8 bits hides.
  bool may_show() const { return allowed > 1.0 / 255; }
};

struct StressResults {
  ResultHead head;
  std::vector<StressRow> rows;
};

/// The document of `--json`.
std::string to_json(const StressResults& results);

}  // namespace swiftgs::cli
