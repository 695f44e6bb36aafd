// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs::cli {

/// Sets some members of conventions.
using Change = std::function<void(Conventions&)>;

/// One question of a conformance set.
struct Clause {
  std::string name;
  std::filesystem::path scene, cameras;
  vec3 background{0};
  int layers = 0;                    ///< most splats that are blended in a pixel
  std::vector<std::string> presets;  ///< that answer it
  Change change;                     ///< of what the clause sets apart

  Scene read_scene() const;
  Camera read_camera() const;
  /// `preset` as the clause has it.
  Conventions conventions(const std::string& preset) const;
};

/// A departure from a preset that renderers are known for.
struct Variant {
  std::string name;
  Change change;
};

struct ConformanceSet {
  int side = 0;  ///< of each image @units{pixels}
  std::vector<Clause> clauses;
  std::vector<Variant> variants;
};

/// The set in `folder`, by its manifest.json. Throws `InvalidArgument` with what the manifest lacks, or
/// `FileError`.
ConformanceSet read_conformance_set(const std::filesystem::path& folder);

}  // namespace swiftgs::cli
