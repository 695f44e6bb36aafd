// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Planes that sum attributes of splats by weight, as colour does: depth along the ray, normal, squared depth
/// and features. Each of their channels is an attribute. Rasterizers sum rows of four attributes, whatever
/// they mean.
///
/// Depth along the ray is a splat's depth at each pixel: where its Gaussian is densest along the pixel's ray,
/// linearised as the splat itself is.

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/passes.hpp>
#include <swiftgs/frame/raster.hpp>
#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/lens/point.hpp>
#include <swiftgs/project/project.hpp>
#include <swiftgs/raster/store.hpp>

namespace swiftgs {

/// Squared depth at `point`, by the six coefficients in `squares` or by weighted sums of such coefficients.
SWIFTGS_HD inline float sum_of_squares(const float* squares, vec2 point) {
  const float linear = squares[1] * point.x + squares[2] * point.y;
  const float by_x = squares[3] * point.x + squares[4] * point.y, by_y = squares[5] * point.y;
  return squares[0] + (linear + (by_x * point.x + by_y * point.y));
}

/// How the image and depth move with a Gaussian's own unit sphere.
struct SphereSlopes {
  ImageAxes<double> image;
  dvec3 depth;
};

SWIFTGS_HD inline SphereSlopes sphere_slopes(const ViewConstants& v, const Gaussian& g) {
  const CameraPoint at(v, g.mean);
  const dvec3 p(at.p[0], at.p[1], at.p[2]);
  const auto image = [&] {
    if (v.through_lens) {
      const LensPoint seen = point_through(v.lens, v.limits, p);
      return ImageAxes<double>(v, LensSlopes{seen.du, seen.dv, v.fx, v.fy}, g.scale, g.rotation);
    }
    const double inverse_z = inverse(p.z);
    const Linearisation<double> by{v.clamped_x(p.x * inverse_z), v.clamped_y(p.y * inverse_z),
                                   v.fx * inverse_z, v.fy * inverse_z};
    return ImageAxes<double>(v, by, g.scale, g.rotation);
  };
  const dvec3 ahead =
      v.depth_is_distance ? p * (v.depth_scale / std::sqrt(dot(p, p))) : dvec3(0.0, 0.0, v.depth_scale);
  dvec3 in_world(0.0), depth;
  for (int row = 0; row < 3; ++row)
    for (int k = 0; k < 3; ++k) in_world[k] += ahead[row] * v.rotation[row][k];
  const LocalAxes<double> axes(g.rotation);
  for (int k = 0; k < 3; ++k) depth[k] = g.scale[k] * dot(in_world, axes.column[k]);
  return {image(), depth};
}

/// Whether sums of planes of depth, and of their squares, stay finite in an image of this size.
SWIFTGS_HD inline bool is_summed(double middle, double x, double y, double width, double height,
                                 float most_squared) {
  const double most = std::fabs(middle) + std::fabs(x) * width + std::fabs(y) * height;
  return most * most <= double(most_squared);
}

/// The depth of a Gaussian that `view` shows at `mean`: the regression of depth on the point in the image, by
/// the covariance that is drawn. `depth` is its mean's. Where squares would exceed `most_squared`, the depth
/// does not vary.
SWIFTGS_HD inline RayDepth ray_depth(const ViewConstants& v, const Gaussian& g, Vector2<double> mean,
                                     float depth, float most_squared) {
  const SphereSlopes by = sphere_slopes(v, g);
  const dvec3 &u = by.image.x, &w = by.image.y, across = cross(u, w);
  const double blur = v.blur, uu = dot(u, u), ww = dot(w, w);
  // Adjugate and determinant of the covariance as sums of squares and products (Binet-Cauchy): differences of
  // products would lose all digits of a needle.
  const double determinant = dot(across, across) + blur * (uu + ww + blur);
  const double x = (dot(across, cross(by.depth, w)) + blur * dot(u, by.depth)) / determinant;
  const double y = (dot(across, cross(u, by.depth)) + blur * dot(w, by.depth)) / determinant;
  const double right = mean.x - 0.5 * v.width, down = mean.y - 0.5 * v.height;
  const double middle = depth - (x * right + y * down);
  if (!is_summed(middle, x, y, v.width, v.height, most_squared)) return {depth, 0, 0};
  return {float(middle), float(x), float(y)};
}

/// A channel of a plane.
struct Attribute {
  enum class Of { nothing, ray_depth, normal, squared_depth, squared_ray_depth, feature } of = Of::nothing;
  int channel = 0;
};

/// The k-th attribute of `view` for `planes`, a `Request` or a `FrameView`.
template <class Planes>
SWIFTGS_HD Attribute attribute(const View& view, const Planes& planes, int k) {
  if (takes_ray_depth(view, planes)) {
    if (k < RayDepth::terms) return {Attribute::Of::ray_depth, k};
    k -= RayDepth::terms;
  }
  if (planes.normal) {
    if (k < 3) return {Attribute::Of::normal, k};
    k -= 3;
  }
  if (planes.squared_depth) {
    const bool along_ray = view.camera.depth_along_ray;
    const int channels = along_ray ? RayDepth::squares : 1;
    if (k < channels) return {along_ray ? Attribute::Of::squared_ray_depth : Attribute::Of::squared_depth, k};
    k -= channels;
  }
  if (planes.features && k < view.frame.feature_channels) return {Attribute::Of::feature, k};
  return {};
}

/// Largest magnitude that is summed: devices sum in units of alpha_max, and no sum may be infinite.
SWIFTGS_HD constexpr float most_attribute(float alpha_max) { return 3.4e38f * alpha_max; }

/// Writes the planes of attributes at column x of row y, by their sums.
SWIFTGS_HD inline void store_attributes(const View& view, const AttributesView& attributes, std::size_t x,
                                        std::size_t y, float transmittance, const float* sums) {
  const FrameView& frame = view.frame;
  const float alpha = 1 - transmittance;
  const auto mean = [&](float sum) { return alpha > 0 ? sum / alpha : 0.0f; };
  for (unsigned i = 0; i < attributes.rows * AttributeRow::channels; ++i) {
    const Attribute to = attribute(view, frame, attributes.first + int(i));
    if (to.of == Attribute::Of::nothing) return;
    if (to.of == Attribute::Of::ray_depth) {
      const RayDepth sum{sums[i], sums[i + 1], sums[i + 2]};
      if (frame.depth.data) frame.depth.row(y)[x] = mean(sum.at(point_of(view, x, y)));
      i += RayDepth::terms - 1;
    } else if (to.of == Attribute::Of::squared_ray_depth) {
      frame.squared_depth.row(y)[x] = mean(sum_of_squares(sums + i, point_of(view, x, y)));
      i += RayDepth::squares - 1;
    } else if (to.of == Attribute::Of::normal) {
      frame.normal.row(y)[3 * x + std::size_t(to.channel)] = sums[i];
    } else if (to.of == Attribute::Of::squared_depth) {
      frame.squared_depth.row(y)[x] = mean(sums[i]);
    } else {
      float* const feature =
          frame.features.row(y) + x * std::size_t(frame.feature_channels) + std::size_t(to.channel);
      const bool as_row = i % AttributeRow::channels == 0 &&
                          to.channel + int(AttributeRow::channels) <= frame.feature_channels &&
                          reinterpret_cast<std::uintptr_t>(feature) % alignof(AttributeRow) == 0;
      if (as_row) {  // one store: a device writes memory by 32 bytes, however little of them it is given
        *reinterpret_cast<AttributeRow*>(feature) = {{sums[i], sums[i + 1], sums[i + 2], sums[i + 3]}};
        i += AttributeRow::channels - 1;
      } else {
        *feature = sums[i];
      }
    }
  }
}

/// Writes the planes of `job` at column x of row y, except the planes of picked splats. `sums` are the sums
/// of the job's attributes.
SWIFTGS_HD inline void store_pixel(const RasterJob& job, const View& view, std::size_t x, std::size_t y,
                                   const BlendedPixel& pixel, const float* sums) {
  if (!job.only_attributes) store_pixel(view.frame, x, y, pixel, view.background);
  if (job.attributes.rows != 0) store_attributes(view, job.attributes, x, y, pixel.transmittance, sums);
}

}  // namespace swiftgs
