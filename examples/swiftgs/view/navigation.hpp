// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/camera.hpp>
#include <swiftgs/default_view.hpp>
#include <swiftgs/frame/math.hpp>

/// @file
/// How mouse and keys move a camera: functions of the camera and the input alone.

namespace swiftgs::cli {

enum class Navigation {
  orbit,  ///< dragging turns the camera around its target
  fly,    ///< dragging looks around, and keys move along the camera's axes
  walk,   ///< as `fly`, but forward and sideways stay level
};

/// What the user did since the last frame.
struct Input {
  vec2 turn{0};  ///< drag of the left button, right and down @units{pixels}
  vec2 pan{0};   ///< drag of another button @units{pixels}
  double wheel = 0;
  dvec3 move{0.0};  ///< way by keys: right, along `OrbitView::up`, forward @units{world}

  bool moves() const { return turn != vec2(0) || pan != vec2(0) || wheel != 0 || move != dvec3(0.0); }
};

/// `view` after `input`. Keys and panning take the target along.
OrbitView moved(const OrbitView& view, Navigation navigation, const Input& input);

/// What `camera` sees, in an image of another size: all of its image, larger or smaller, in the middle.
Camera fitted(Camera camera, int width, int height);

/// The view through `camera`, whose target is ahead of it, as far away as `near_to`, or `least` at least.
OrbitView view_through(const Camera& camera, const dvec3& up, const dvec3& near_to, double least);

}  // namespace swiftgs::cli
