// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <filesystem>
#include <string_view>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/stress.hpp>

namespace swiftgs::cli {

/// The name by which `render` knows the float64 reference.
inline constexpr std::string_view reference_name = "reference";

/// Placed scenes as the reference takes them.
class ReferenceScenes {
 public:
  /// `scene` must outlive this.
  void add(const Scene& scene, const Placement& placement);
  Span<const ReferenceScene> all() const { return {scenes_.data(), scenes_.size()}; }

 private:
  std::deque<Scene> parts_;  ///< of scenes that show in part
  std::vector<ReferenceScene> scenes_;
};

/// How far ambiguous decisions may move any channel of each pixel, which a judge allows.
std::vector<double> ambiguity_of(const ConditionedFrame& frame);

/// RGBA of each pixel, premultiplied; colours have the background.
template <class AnyFrame>
std::vector<double> rgba_of(const AnyFrame& frame) {
  std::vector<double> rgba;
  for (std::size_t i = 0; i < frame.alpha.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) rgba.push_back(double(frame.colour[3 * i + c]));
    rgba.push_back(double(frame.alpha[i]));
  }
  return rgba;
}

/// Draws a view by the reference into `file`, whose ending is png, pfm, exr or npy. A PNG has alpha if
/// `with_alpha`. An EXR has the ambiguity of each pixel as channel features.0; beside NAME.npy it is
/// NAME.ambiguous.npy. Throws as `render_conditioned` and the writers.
void draw_reference(const std::filesystem::path& file, const ReferenceScenes& scenes, const Camera& camera,
                    const RenderSettings& settings);

}  // namespace swiftgs::cli
