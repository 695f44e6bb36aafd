// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "hard_frames/families.hpp"

namespace swiftgs::cli {

/// A family at one severity and image size.
struct StressPoint {
  const StressFamily* family = nullptr;
  double severity = 0;
  ImageSize size;
};

/// Those of `families` that `names` lists, all where it is empty, in their order. Throws
/// `InvalidArgument` with the valid names.
std::vector<const StressFamily*> families_named(const std::string& names,
                                                const std::vector<StressFamily>& families);

/// Every combination, size by size such as `64x48,960x540`, and family by family. `severities` is `max`,
/// `all` or numbers. Throws `InvalidArgument`.
std::vector<StressPoint> points_of(const std::string& families, const std::string& severities,
                                   const std::string& sizes);

/// As 1e10, 0.1 or inf.
std::string severity_text(double severity);

}  // namespace swiftgs::cli
