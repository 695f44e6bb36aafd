// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/scene.hpp>

#include "bench/results.hpp"
#include "read/views.hpp"

namespace swiftgs::cli {

/// How many frames are timed.
struct Plan {
  int min_frames = 8, max_frames = 48;
  double precision =
      0.01;  ///< half the interval of the total's median that is narrow enough, as a part of it
  std::uint32_t seed = 1;
};

/// Throws `InvalidArgument` for a plan that no frame can be measured by.
void validate(const Plan& plan);

/// Median, its confidence interval and two percentiles of `values`, at least one. Of fewer than six values
/// the interval is all of them: no narrower one holds the median with 95 %.
Duration summary_of(std::vector<double> values);

/// Durations of the frames of one renderer, over their number of views. @units{milliseconds}
struct Samples {
  std::vector<double> project, sort, raster, total, wall;

  int frames() const { return int(total.size()); }
  Durations summary() const;
};

/// Draws a frame for `cameras` until an adaptive sort has decided for its size, or once.
void adapt(AnyRenderer& renderer, Span<const Camera> cameras, const RenderSettings& settings);

/// Times frames for `cameras`, a view each, by their duration over the number of views. They stay with the
/// backends. In each round every renderer has its turn, in a new order each time, so a machine that drifts is
/// no one's advantage; a turn begins with a frame that is not timed, since the caches are the previous
/// renderer's. A renderer whose median is precise enough has no further turns. `finished` is called with the
/// number of each that is, and its samples. Throws `Interrupted` after Ctrl-C.
std::vector<Samples> measure(const std::vector<AnyRenderer*>& renderers, Span<const Camera> cameras,
                             const RenderSettings& settings, const Plan& plan,
                             const std::function<void(std::size_t, const Samples&)>& finished = {});

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
