// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/lens.hpp>
#include <swiftgs/frame/math.hpp>

namespace swiftgs {

namespace detail {
inline double dot(dvec3 a, dvec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline dvec3 cross(dvec3 a, dvec3 b) {
  return dvec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
}  // namespace detail

/// Camera, OpenCV axes (x right, y down, z forward): p_camera = rotation p_world + translation. A
/// rotation of determinant -1 is a mirror: it shows the image of the mirrored world.
/// World axes are the scene's own, right-handed; scenes of captures and readers' results have y down, so that
/// up is about -y. `camera_from` of <swiftgs/camera_matrices.hpp> takes matrices of other renderers.
/// Pixel (column i, row j) is sampled at (i + 0.5, j + 0.5); the principal point may lie anywhere.
struct Camera {
  dmat3 rotation{1.0};        ///< world to camera; GLM stores it by columns: rotation[column][row]
  dvec3 translation{0.0};     ///< camera-space position of the world's origin
  double fx = 0, fy = 0;      ///< focal lengths @units{pixels}, per unit of the lens's plane
  double cx = 0, cy = 0;      ///< principal point from the top left corner @units{pixels}
  int width = 0, height = 0;  ///< @units{pixels}
  Lens lens;                  ///< a pinhole unless said otherwise
  std::string name;           ///< image that the camera belongs to, or empty

  /// Position of the camera in the world.
  dvec3 centre() const {
    // By the inverse, not the transpose: a rotation is orthonormal to as many digits as its file has.
    const dvec3 rows[3] = {detail::cross(rotation[1], rotation[2]), detail::cross(rotation[2], rotation[0]),
                           detail::cross(rotation[0], rotation[1])};
    const double determinant = detail::dot(rotation[0], rows[0]);
    return dvec3(detail::dot(rows[0], translation), detail::dot(rows[1], translation),
                 detail::dot(rows[2], translation)) /
           -determinant;
  }
};

/// Valid focal lengths, and the largest distance of the principal point from the image's corner. Numbers
/// beyond these would leave the range of float. @units{pixels}
inline constexpr double min_focal_length = 1e-6, max_focal_length = 1e12, max_principal_point = 1e9;

/// How far the products of a rotation's rows may be from 1 and 0.
inline constexpr double max_rotation_error = 1e-3;

/// Pixels of a full turn, of a camera whose lens is equirectangular.
inline double turn_of(const Camera& camera) { return 6.283185307179586 * camera.fx; }

/// Width of the parts in which a panorama is drawn, counted from its column 0: an eighth of a turn, rounded
/// up to whole blocks of pixels; 0 for other lenses, and where an eighth is wider than any image. Each part
/// shows the copy of a splat that is nearest to the part's middle, so a splat that reaches less than half a
/// turn less half a part to each side has no seam.
inline int panorama_part(const Camera& camera) {
  if (!traits_of(camera.lens.model).shows_sphere) return 0;
  const double eighth = turn_of(camera) / 8 * (1 - 1e-12);
  if (eighth > max_image_side) return 0;
  const int step = eighth > 64 ? 32 : 16;  // whole tiles, coarse ones in images that may have them
  return int(std::ceil(eighth / step)) * step;
}

/// Throws `InvalidArgument` that names the first invalid member.
inline void validate(const Camera& camera) {
  const auto require = [](bool holds, const char* expected) {
    if (!holds) detail::refuse("camera: expected ", expected);
  };
  require(camera.width > 0 && camera.height > 0, "a width and a height above 0");
  require(camera.width <= max_image_side && camera.height <= max_image_side, "at most 65536 pixels a side");
  const auto focal = [](double f) {
    return detail::is_finite(f) && f >= min_focal_length && f <= max_focal_length;
  };
  require(focal(camera.fx) && focal(camera.fy), "focal lengths of 1e-6 to 1e12 pixels");
  const auto central = [](double c) { return detail::is_finite(c) && std::abs(c) <= max_principal_point; };
  require(central(camera.cx) && central(camera.cy), "a principal point at most 1e9 pixels from the corner");
  validate(camera.lens);
  require(!traits_of(camera.lens.model).shows_sphere || camera.width <= std::ceil(turn_of(camera)),
          "at most 2 pi fx pixels a row of an equirectangular lens");
  for (int i = 0; i < 3; ++i) {
    require(detail::is_finite(camera.translation[i]), "a finite translation");
    for (int j = 0; j < 3; ++j) {
      double dot = 0;
      for (int k = 0; k < 3; ++k) dot += camera.rotation[i][k] * camera.rotation[j][k];
      require(detail::is_finite(dot) && std::abs(dot - (i == j ? 1.0 : 0.0)) < max_rotation_error,
              "a rotation with orthonormal rows");
    }
  }
}

/// The same view at `scale` times the size: image position p moves to scale p, corners and centres alike.
/// Sides are rounded to whole pixels, at least one, so the last ones may show a little more or less.
inline Camera scaled(Camera camera, double scale) {
  if (!(scale > 0) || !detail::is_finite(scale))
    throw InvalidArgument("camera: expected a finite scale above 0");
  const auto side = [&](int pixels) {
    const double rounded = std::round(pixels * scale);
    return rounded < 1 ? 1 : rounded > max_image_side ? max_image_side + 1 : int(rounded);
  };
  camera.fx *= scale, camera.fy *= scale, camera.cx *= scale, camera.cy *= scale;
  camera.width = side(camera.width), camera.height = side(camera.height);
  return camera;
}

/// A camera at `eye` that looks at `target`, `up` pointing up in the image, principal point in the centre.
/// `vertical_fov` is the full angle @units{radians}.
inline Camera look_at(dvec3 eye, dvec3 target, dvec3 up, double vertical_fov, int width, int height) {
  using detail::cross, detail::dot;
  const auto unit = [&](dvec3 v) {
    const double length = std::sqrt(dot(v, v));
    if (!(length > 0)) throw InvalidArgument("look_at: expected eye, target and up to span a frame");
    return v / length;
  };
  const dvec3 z = unit(target - eye), x = unit(cross(z, up)), y = cross(z, x);
  Camera camera;
  for (int column = 0; column < 3; ++column) camera.rotation[column] = dvec3(x[column], y[column], z[column]);
  camera.translation = dvec3(-dot(x, eye), -dot(y, eye), -dot(z, eye));
  camera.fx = camera.fy = 0.5 * height / std::tan(0.5 * vertical_fov);
  camera.cx = 0.5 * width, camera.cy = 0.5 * height;
  camera.width = width, camera.height = height;
  return camera;
}

}  // namespace swiftgs
