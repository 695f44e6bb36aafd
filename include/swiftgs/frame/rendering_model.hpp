// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

#include <swiftgs/error.hpp>

namespace swiftgs {

/// What orders the splats of a frame.
enum class SplatOrder {
  depth,     ///< as `Conventions::depth` measures it
  distance,  ///< from the camera's centre
};

/// The values in which splats are blended. Frames have the same kind of values whichever it is.
enum class ColourSpace {
  srgb,    ///< encoded for a display, as photographs are
  linear,  ///< linear light; each pixel is encoded when it is finished
};

/// How a scene was trained to be drawn. Readers take it from the file; frames follow it wherever
/// `Conventions` leave it to the scene.
struct RenderingModel {
  /// What was trained.
  enum class Kernel {
    ellipsoid,  ///< 3D Gaussians
    disk,       ///< 2D Gaussians in space, drawn as 3D ones that are flat: not as they were trained
  };

  float blur = 0.3f;         ///< as `Conventions::blur` @units{pixels^2}
  bool antialiased = false;  ///< as `Conventions::antialiased`
  SplatOrder order = SplatOrder::depth;
  ColourSpace colours = ColourSpace::srgb;
  Kernel kernel = Kernel::ellipsoid;

  bool operator==(const RenderingModel&) const = default;
};

namespace detail {
inline bool is_blur(float blur) { return blur >= 0 && blur < std::numeric_limits<float>::infinity(); }
}  // namespace detail

/// Throws `InvalidArgument` if no frame can follow `model`.
inline void validate(const RenderingModel& model) {
  if (!detail::is_blur(model.blur))
    detail::refuse("scene: the blur of its model is ", model.blur, ", expected 0 or more");
}

}  // namespace swiftgs
