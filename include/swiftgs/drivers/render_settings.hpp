// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/render_input.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/lens/view.hpp>

namespace swiftgs {

/// What a frame is rendered with, beside scene and camera.
struct RenderSettings {
  Conventions conventions;
  /// RGB in the frame's values before its `conversion`, sRGB-encoded of most scenes; shown where
  /// transmittance is left; has no part in alpha.
  vec3 background{0};
  Outputs outputs;  ///< of `render`; `render_into` computes what its frame points to
  /// Fill all of `Statistics`. A host takes some time for it; of a device's frame the host waits, downloads
  /// splats and lists, and blends them anew, which may take seconds.
  bool count = false;
  bool time = false;  ///< take the `times` of the frame, which costs a device some microseconds
};

/// What a frame tells beside its images.
struct Measures {
  bool count = false;  ///< as `RenderSettings::count`
  bool time = false;   ///< as `RenderSettings::time`
};

/// Throws `InvalidArgument` where nothing can be rendered with `settings`.
inline void validate(const RenderSettings& settings) {
  validate(settings.conventions);
  detail::require_finite_background(settings.background);
  if (settings.outputs.features < 0)
    detail::refuse("render: the number of features is ", settings.outputs.features, ", expected 0 or more");
}

/// Fills `views` with one view for each camera. They ask for the settings' outputs; their frames have no
/// memory yet. Throws as `validate` and `make_view`.
inline void make_views(Span<const Camera> cameras, const RenderSettings& settings, std::vector<View>& views) {
  views.clear();
  validate(settings);
  for (const Camera& camera : cameras) {
    const FrameView frame{
        .width = camera.width, .height = camera.height, .feature_channels = settings.outputs.features};
    views.push_back(make_view(camera, settings.conventions, frame, settings.background));
    views.back().request = Request::planes_of(settings.outputs);
  }
}

}  // namespace swiftgs
