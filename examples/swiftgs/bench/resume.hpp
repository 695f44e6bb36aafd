// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bench/results.hpp"

namespace swiftgs::cli {

/// What an earlier run of the command of `head` left in the file at `path`; no rows where the file is not
/// there. Throws `Unavailable` with `path` where it holds anything else, or is of another machine,
/// build or command.
Results resumed_results(const std::string& path, const ResultHead& head);

/// Throws `Unavailable` with `path` unless `found`, if it holds the scene, has the Gaussians of
/// `scene`.
void require_same_scene(const std::string& path, const Results& found, const SceneResult& scene);

}  // namespace swiftgs::cli
