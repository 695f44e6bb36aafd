// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/lens.hpp>
#include <swiftgs/scene.hpp>

#include "json.hpp"
#include "read/views.hpp"

namespace CLI {
class App;
}

namespace swiftgs::cli {

/// What says through which lens views are seen.
struct LensOptions {
  std::string lens;  ///< a `LensModel`; empty for those of the cameras
  bool panorama = false;
  std::string depth_by;             ///< `z` or `distance`; empty for the lens's own
  std::string depth_at = "centre";  ///< or `ray`
};

/// Adds the options of lenses.
void add_lens(CLI::App& command, LensOptions& options);

/// Throws `InvalidArgument` for names that are not known, and for a panorama of another lens.
void validate(const LensOptions& options);

/// What `--depth-by` and `--depth-at` say.
Conventions::Depth depth_of(const LensOptions& options);
Conventions::DepthAt depth_at_of(const LensOptions& options);

/// Gives `views` of `scene`, all of them found, the lens that was asked for.
void use_lens(std::vector<View>& views, const LensOptions& options, const Scene& scene);

/// The model's name, with ", distorted" where it is.
std::string words_of(const Lens& lens);

/// Prints an image's file and its frame's times; of a counted frame its statistics too.
void print(const RenderResult& result);

}  // namespace swiftgs::cli
