// SPDX-License-Identifier: Apache-2.0
#include "view/navigation.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace swiftgs::cli {
namespace {

constexpr double radians_a_pixel = 0.005, closer_a_step = 0.9;

/// Direction in the world of an axis of the camera: 0 right, 1 down, 2 forward.
dvec3 axis_of(const Camera& camera, int axis) {
  return {camera.rotation[0][axis], camera.rotation[1][axis], camera.rotation[2][axis]};
}

void shift(OrbitView& view, const dvec3& by) {
  view.camera.translation -= view.camera.rotation * by;
  view.target += by;
}

double distance_of(const OrbitView& view) { return glm::length(view.target - view.camera.centre()); }

/// Turns the camera where it stands: as an orbit around a target in the middle of the image does, moved back.
void look(OrbitView& view, double right, double down) {
  const dvec3 centre = view.camera.centre();
  const double distance = distance_of(view);
  view.target = centre + distance * axis_of(view.camera, 2);
  view.camera.rotation = orbit(view, -right, down).rotation;
  view.camera.translation = -(view.camera.rotation * centre);
  view.target = centre + distance * axis_of(view.camera, 2);
}

/// `v` without its part along the unit vector `up`, of length 1 again; as it is where nothing is left.
dvec3 level(const dvec3& v, const dvec3& up) {
  const dvec3 flat = v - glm::dot(v, up) * up;
  return glm::length(flat) > 1e-9 ? glm::normalize(flat) : v;
}

}  // namespace

OrbitView moved(const OrbitView& view, Navigation navigation, const Input& input) {
  OrbitView out = view;
  const dvec3 up = glm::normalize(view.up);
  const bool orbits = navigation == Navigation::orbit;
  if (orbits && (input.turn != vec2(0) || input.wheel != 0))
    out.camera = orbit(out, -radians_a_pixel * input.turn.x, radians_a_pixel * input.turn.y,
                       std::pow(closer_a_step, input.wheel));
  else if (input.turn != vec2(0))
    look(out, radians_a_pixel * input.turn.x, radians_a_pixel * input.turn.y);

  dvec3 right = axis_of(out.camera, 0), forward = axis_of(out.camera, 2);
  if (navigation == Navigation::walk) right = level(right, up), forward = level(forward, up);
  const double distance = distance_of(out);
  const double wheel = orbits ? 0 : (1 - closer_a_step) * distance * input.wheel;
  shift(out, input.move.x * right + input.move.y * up + (input.move.z + wheel) * forward);
  // What lies at the target's distance goes with the mouse.
  shift(out, -(distance * input.pan.x / out.camera.fx) * axis_of(out.camera, 0) -
                 (distance * input.pan.y / out.camera.fy) * axis_of(out.camera, 1));
  return out;
}

Camera fitted(Camera camera, int width, int height) {
  const double across = double(width) / camera.width, down = double(height) / camera.height;
  // A panorama has no more than its image.
  const double scale =
      traits_of(camera.lens.model).shows_sphere ? std::max(across, down) : std::min(across, down);
  camera.cx = 0.5 * width + scale * (camera.cx - 0.5 * camera.width);
  camera.cy = 0.5 * height + scale * (camera.cy - 0.5 * camera.height);
  camera.fx *= scale, camera.fy *= scale;
  camera.width = width, camera.height = height;
  return camera;
}

OrbitView view_through(const Camera& camera, const dvec3& up, const dvec3& near_to, double least) {
  const dvec3 centre = camera.centre(), forward = axis_of(camera, 2);
  return {camera, centre + std::max(least, glm::dot(near_to - centre, forward)) * forward, up};
}

}  // namespace swiftgs::cli
