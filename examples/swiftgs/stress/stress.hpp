// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/any_renderer.hpp>

namespace swiftgs::cli {

struct StressOptions {
  std::string renderers = "*/early/*/ellipse";
  std::string families;  ///< separated by commas; empty for all
  std::string severities = "all", sizes = "64x48";
  int seeds = 8;
  std::optional<std::int64_t> threads;
  bool scene_only = false;  ///< as of `StressTrials`
  std::string json;
  std::optional<double> search;  ///< for so long, in place of the families' own frames @units{seconds}
  std::uint64_t seed = 1;        ///< of the search
};

/// Runs the command with renderers of any table: prints tables and writes the file. Throws
/// `InvalidArgument` for options that make no sense, and afterwards `Unavailable` where a
/// normalised error is above `stress_gate` or a renderer threw.
void stress(const StressOptions& options, const std::vector<RendererEntry>& entries);

/// `stress --search`: climbs until the time is over, then prints tables and writes the file. Throws as
/// `stress`.
void search(const StressOptions& options, const std::vector<RendererEntry>& entries);

}  // namespace swiftgs::cli
