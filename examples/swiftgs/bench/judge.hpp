// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <swiftgs/conventions.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/scene.hpp>

#include "bench/results.hpp"
#include "read/views.hpp"

namespace swiftgs::cli {

/// What frames of one view are compared with. Many renderers draw the same bits, and each image is judged
/// once.
class Judge {
 public:
  /// Compares with the photograph alone, where there is one; `settings` are what the frames are drawn with.
  Judge(std::shared_ptr<const Scene> scene, const Camera& camera, const RenderSettings& settings,
        std::optional<Image> photo);

  /// Renders the reference: from then on there are errors.
  void render_reference();

  struct Verdict {
    std::optional<Errors> errors;
    std::optional<PhotoErrors> photo;
  };
  /// `cut`: whether the frame's bounds are those of `ThreeSigmaSquare`.
  Verdict of(const Frame& frame, bool cut);

  /// Of the reference itself; nothing without photograph or reference.
  std::optional<PhotoErrors> reference_photo() const;

 private:
  std::vector<double> render(Conventions::Footprint footprint) const;

  std::shared_ptr<const Scene> scene_;
  Camera camera_;
  RenderSettings settings_;
  std::optional<Image> photo_;
  std::vector<double> truth_, cut_truth_;                  ///< colours; the second when it is first asked for
  std::map<std::pair<std::size_t, bool>, Verdict> known_;  ///< by the frame's hash and `cut`
};

}  // namespace swiftgs::cli
