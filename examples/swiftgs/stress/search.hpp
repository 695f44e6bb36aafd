// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stress/stress.hpp"

namespace swiftgs::cli {

/// `stress --search`: climbs until the time is over, then prints tables and writes the file. Throws as
/// `stress`.
void search(const StressOptions& options, const std::vector<RendererEntry>& entries);

}  // namespace swiftgs::cli
