// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "result_head.hpp"
#include "stress/sweep.hpp"

namespace swiftgs::cli {

/// With as many digits as count: 0.03, 2.6 or 104; inf where it is not finite.
std::string error_text(double error);

/// Prints a list for each image size and family: a line a renderer. Then what is to be said of each renderer,
/// and of each row in which it failed.
void print_stress(const std::vector<StressRow>& rows);

}  // namespace swiftgs::cli

/// What `stress --search` finds.
namespace swiftgs::cli {

/// The worst frame of one renderer, of colours or of depth, that a search found from one family.
struct SearchRow {
  std::string renderer, family, plane;
  std::uint64_t tries = 0;  ///< frames that were drawn, of all families
  double normalised_error = 0;
  std::string error;  ///< what the renderer threw, or what is wrong with its frame; or empty

  static auto members(auto& self) {
    return std::tie(self.renderer, self.family, self.plane, self.tries, self.normalised_error, self.error);
  }
};

/// The document of `--json`.
std::string to_json(const ResultHead& head, const std::vector<SearchRow>& rows);

/// Prints a table for each renderer: what it draws worst, a row a family and plane.
void print_search(const std::vector<SearchRow>& rows);

}  // namespace swiftgs::cli
