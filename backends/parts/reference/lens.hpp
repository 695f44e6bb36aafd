// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/lens/limits.hpp>
#include <swiftgs/lens/view.hpp>

namespace swiftgs::reference {

/// Where a lens shows a point of camera space. @units{pixels}
struct SeenPoint {
  double x = 0, y = 0;
  Eigen::Matrix<double, 2, 3> jacobian;  ///< of both by the point
};

/// The lens of a camera, from the formulas of `LensModel` and `Distortion`; derivatives are taken
/// automatically.
class CameraLens {
 public:
  CameraLens(const Camera& camera, const Conventions& conventions)
      : camera_(camera),
        by_distance_(depth_is_distance(camera.lens.model, conventions)),
        limits_(lens_limits(camera, conventions)) {
    if (!camera.lens.is_pinhole()) return;
    // Exactly as the conventions have it.
    const double half_x = camera.width / (2 * camera.fx), half_y = camera.height / (2 * camera.fy);
    if (conventions.clamp == Conventions::JacobianClamp::around_image) {
      limits_.least_u = -(camera.cx / camera.fx + 0.3 * half_x);
      limits_.most_u = (camera.width - camera.cx) / camera.fx + 0.3 * half_x;
      limits_.least_v = -(camera.cy / camera.fy + 0.3 * half_y);
      limits_.most_v = (camera.height - camera.cy) / camera.fy + 0.3 * half_y;
    } else {
      limits_.least_u = -1.3 * half_x, limits_.most_u = 1.3 * half_x;
      limits_.least_v = -1.3 * half_y, limits_.most_v = 1.3 * half_y;
    }
  }

  /// Whether `depth` is the distance from the camera rather than z.
  bool by_distance() const { return by_distance_; }

  /// What is compared with the planes, and usually orders splats.
  double depth(const Eigen::Vector3d& p) const { return by_distance_ ? p.stableNorm() : p.z(); }

  /// Nothing where the lens shows no points. Of a panorama the copy nearest to the column `middle`.
  std::optional<SeenPoint> point(const Eigen::Vector3d& p, double middle) const {
    switch (camera_.lens.model) {
      case LensModel::perspective:
        return perspective(p);
      case LensModel::fisheye:
        return fisheye(p);
      case LensModel::orthographic:
        return in_pixels(p.x(), p.y(), {1, 0, 0}, {0, 1, 0});
      case LensModel::equirectangular:
        return equirectangular(p, middle);
    }
    return {};
  }

 private:
  using Dual = Eigen::AutoDiffScalar<Eigen::Vector3d>;
  struct Plane {
    Dual u, v;
  };

  static Dual variable(double value, int index) { return Dual(value, 3, index); }

  SeenPoint in_pixels(double u, double v, const Eigen::Vector3d& du, const Eigen::Vector3d& dv) const {
    SeenPoint out{camera_.fx * u + camera_.cx, camera_.fy * v + camera_.cy, {}};
    out.jacobian.row(0) = camera_.fx * du.transpose(), out.jacobian.row(1) = camera_.fy * dv.transpose();
    return out;
  }

  Plane distorted(const Plane& at) const {
    const Distortion& d = camera_.lens.distortion;
    const Dual r2 = at.u * at.u + at.v * at.v, r4 = r2 * r2, r6 = r4 * r2, r8 = r4 * r4;
    const Dual radial = (1.0 + d.radial[0] * r2 + d.radial[1] * r4 + d.radial[2] * r6 + d.radial[3] * r8) /
                        (1.0 + d.rational[0] * r2 + d.rational[1] * r4 + d.rational[2] * r6);
    return {Dual(at.u * radial + 2 * d.tangential[0] * at.u * at.v +
                 d.tangential[1] * (r2 + 2 * at.u * at.u) + d.prism[0] * r2),
            Dual(at.v * radial + d.tangential[0] * (r2 + 2 * at.v * at.v) +
                 2 * d.tangential[1] * at.u * at.v + d.prism[1] * r2)};
  }

  /// Whether the distortion at (u, v) keeps the image's orientation, before its fold.
  bool is_before_fold(double u, double v) const {
    if (!(u * u + v * v < limits_.fold_squared)) return false;
    const Plane moved = distorted({variable(u, 0), variable(v, 1)});
    const Eigen::Vector3d du = moved.u.derivatives(), dv = moved.v.derivatives();
    return du[0] * dv[1] - du[1] * dv[0] > 0 && du[0] + dv[1] > 0;
  }

  std::optional<SeenPoint> perspective(const Eigen::Vector3d& p) const {
    const double z = p.z(), u = p.x() / z, v = p.y() / z;
    const double at_u = std::clamp(u, limits_.least_u, limits_.most_u);
    const double at_v = std::clamp(v, limits_.least_v, limits_.most_v);
    if (camera_.lens.is_pinhole()) {
      if (!(z > 0)) return {};
      const Eigen::Vector3d du(1 / z, 0, -at_u / z), dv(0, 1 / z, -at_v / z);
      return in_pixels(u, v, du, dv);
    }
    if (!(z > 0) || !is_before_fold(u, v)) return {};
    const bool within = at_u * at_u + at_v * at_v < limits_.fold_squared;
    // The tangents move with the point as a pinhole's do where the derivatives are taken.
    const double by_u = within ? at_u : u, by_v = within ? at_v : v;
    const Plane place = distorted({variable(u, 0), variable(v, 1)});
    const Plane moved = distorted(
        {Dual(by_u, Eigen::Vector3d(1 / z, 0, -by_u / z)), Dual(by_v, Eigen::Vector3d(0, 1 / z, -by_v / z))});
    return in_pixels(place.u.value(), place.v.value(), moved.u.derivatives(), moved.v.derivatives());
  }

  std::optional<SeenPoint> fisheye(const Eigen::Vector3d& p) const {
    const Dual x = variable(p.x(), 0), y = variable(p.y(), 1), z = variable(p.z(), 2);
    Plane at;
    if (p.x() == 0 && p.y() == 0) {
      if (!(p.z() > 0)) return {};
      at = {Dual(x / z), Dual(y / z)};  // to first order
    } else {
      const Dual across = sqrt(Dual(x * x + y * y)), angle = atan2(across, z);
      at = {Dual(angle * x / across), Dual(angle * y / across)};
    }
    if (!is_before_fold(at.u.value(), at.v.value())) return {};
    const Plane moved = distorted(at);
    return in_pixels(moved.u.value(), moved.v.value(), moved.u.derivatives(), moved.v.derivatives());
  }

  std::optional<SeenPoint> equirectangular(const Eigen::Vector3d& p, double middle) const {
    const double level = std::hypot(p.x(), p.z()), distance = p.stableNorm();
    if (!(distance > 0)) return {};
    if (level == 0) return {};  // a pole has every azimuth
    const Dual x = variable(p.x(), 0), y = variable(p.y(), 1), z = variable(p.z(), 2);
    const Dual azimuth = atan2(x, z), elevation = atan2(y, Dual(sqrt(Dual(x * x + z * z))));
    const double least = distance / limits_.most_cosecant;
    const Eigen::Vector3d by_azimuth = azimuth.derivatives() * (level / std::max(level, least));
    SeenPoint out = in_pixels(azimuth.value(), elevation.value(), by_azimuth, elevation.derivatives());
    const double turn = 2 * std::numbers::pi * camera_.fx;
    out.x -= turn * std::round((out.x - middle) / turn);
    return out;
  }

  Camera camera_;
  bool by_distance_;
  LensLimits limits_;
};

}  // namespace swiftgs::reference
