// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <type_traits>

#include <swiftgs/frame/float_pair.hpp>
#include <swiftgs/frame/lens.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/rendering_model.hpp>

namespace swiftgs {

/// The type that projects means through a pinhole: pairs of floats on GPUs whose multiprocessors have two to
/// four units for double beside 64 or 128 for float, double elsewhere. With SWIFTGS_PROJECT_IN_PAIRS tests
/// run the kernels in pairs on every GPU.
#if defined(__CUDA_ARCH__) &&                                                             \
    (defined(SWIFTGS_PROJECT_IN_PAIRS) || __CUDA_ARCH__ == 750 || __CUDA_ARCH__ == 860 || \
     __CUDA_ARCH__ == 870 || __CUDA_ARCH__ == 890 || __CUDA_ARCH__ == 1200 || __CUDA_ARCH__ == 1210)
using ProjectingReal = FloatPair;
#else
using ProjectingReal = double;
#endif
inline constexpr bool projects_in_pairs = std::is_same_v<ProjectingReal, FloatPair>;

/// Numbers of `ViewConstants` as pairs of floats, made once a view: units for double convert them, and pairs
/// are for GPUs that have few. The high parts of the rotation and of the focal lengths are `axes`, `focal_x`
/// and `focal_y`.
struct PairConstants {
  float axes_low[3][3], focal_x_low, focal_y_low;
  FloatPair centre[3], depth_scale, cx, cy;

  bool operator==(const PairConstants&) const = default;
};

/// Constants of a camera and its conventions for projection, computed once a frame; or of the eye of a placed
/// scene, whose world is the scene's own space.
/// The pose stays in double: rounding it to float moves splats by more than all later arithmetic does.
struct ViewConstants {
  double rotation[3][3];  ///< rows: world to camera
  float axes[3][3];       ///< the rotation in float
  float blur;             ///< @units{pixels^2}
  double centre[3];       ///< camera centre in the world
  double depth_scale;     ///< depths for a unit of camera space; 1 but of a placed scene's eye
  float opacity;          ///< of all Gaussians; 1 but of a placed scene's eye
  bool antialiased;
  bool blur_of_scene, antialiased_of_scene;  ///< `follow` takes these from the scene
  float focal_x, focal_y;                    ///< fx and fy in float @units{pixels}
  double fx, fy;                             ///< @units{pixels}
  PairConstants pairs;                       ///< by `set_pairs`
  double cx, cy;                             ///< @units{pixels}
  float width, height;                       ///< of the image @units{pixels}
  float left, top, right, bottom;            ///< part of it that is shown @units{pixels}
  float near_plane, far_plane;               ///< kept where near_plane < z <= far_plane
  float min_compensation;
  float alpha_min;
  bool through_lens;       ///< not a pinhole that takes z alone, and so projected by `project_through_lens`
  bool depth_is_distance;  ///< rather than z
  bool order_is_distance;  ///< rather than depth
  bool depth_along_ray;    ///< rather than means' depths
  double turn;             ///< all around, of a panorama; 0 of other images @units{pixels}
  double panorama_middle;  ///< column whose nearest copy of a splat a panorama shows
  Lens lens;
  LensLimits limits;

  bool operator==(const ViewConstants&) const = default;

  static constexpr unsigned pair_count = 17;
  /// Sets one of `pairs`: the rotation, the centre, focal lengths, scale, principal point.
  SWIFTGS_HD void set_pair(unsigned k) {
    if (k < 9)
      pairs.axes_low[k / 3][k % 3] = FloatPair::from(rotation[k / 3][k % 3]).low;
    else if (k < 12)
      pairs.centre[k - 9] = FloatPair::from(centre[k - 9]);
    else if (k < 14)
      (k == 12 ? pairs.focal_x_low : pairs.focal_y_low) = FloatPair::from(k == 12 ? fx : fy).low;
    else if (k == 14)
      pairs.depth_scale = FloatPair::from(depth_scale);
    else
      (k == 15 ? pairs.cx : pairs.cy) = FloatPair::from(k == 15 ? cx : cy);
  }
  SWIFTGS_HD void set_pairs() {
    for (unsigned k = 0; k < pair_count; ++k) set_pair(k);
  }

  /// Takes what is left to the scene from the model of the one that is seen.
  SWIFTGS_HD void follow(const RenderingModel& model) {
    if (blur_of_scene) blur = model.blur;
    if (antialiased_of_scene) antialiased = model.antialiased;
  }
  SWIFTGS_HD void order_by_distance() { through_lens = order_is_distance = true; }

  /// Column of the copy of a panorama's column `x` that is nearest to `panorama_middle`.
  SWIFTGS_HD double nearest_copy(double x) const {
    return turn == 0 ? x : x - turn * std::round((x - panorama_middle) / turn);
  }

  /// x/z and y/z within their limits.
  template <class Real>
  SWIFTGS_HD Real clamped_x(Real tangent) const {
    return clamped<Real>(tangent, Real(limits.least_u), Real(limits.most_u));
  }
  template <class Real>
  SWIFTGS_HD Real clamped_y(Real tangent) const {
    return clamped<Real>(tangent, Real(limits.least_v), Real(limits.most_v));
  }

 private:
  template <class Real>
  SWIFTGS_HD static Real clamped(Real tangent, Real least, Real most) {
    return tangent < least ? least : tangent > most ? most : tangent;
  }
};

/// The numbers that project a mean as `Real`, double or `FloatPair`.
template <class Real>
class ProjectingConstants {
 public:
  SWIFTGS_HD explicit ProjectingConstants(const ViewConstants& view) : v_(view) {}

  SWIFTGS_HD Real rotation(int row, int column) const {
    return chosen(v_.rotation[row][column], {v_.axes[row][column], v_.pairs.axes_low[row][column]});
  }
  SWIFTGS_HD Real centre(int k) const { return chosen(v_.centre[k], v_.pairs.centre[k]); }
  SWIFTGS_HD Real depth_scale() const { return chosen(v_.depth_scale, v_.pairs.depth_scale); }
  SWIFTGS_HD Real fx() const { return chosen(v_.fx, {v_.focal_x, v_.pairs.focal_x_low}); }
  SWIFTGS_HD Real fy() const { return chosen(v_.fy, {v_.focal_y, v_.pairs.focal_y_low}); }
  SWIFTGS_HD Real cx() const { return chosen(v_.cx, v_.pairs.cx); }
  SWIFTGS_HD Real cy() const { return chosen(v_.cy, v_.pairs.cy); }

 private:
  SWIFTGS_HD static Real chosen(double in_double, FloatPair in_pairs) {
    if constexpr (std::is_same_v<Real, double>)
      return in_double;
    else
      return in_pairs;
  }

  const ViewConstants& v_;
};

}  // namespace swiftgs
