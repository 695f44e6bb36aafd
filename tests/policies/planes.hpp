// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames with all planes, against the reference.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/drivers/pick.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/renderer.hpp>

#include "policies/all_planes.hpp"
#include "policies/random_splats.hpp"
#include "policies/tile_lists.hpp"

namespace swiftgs::test {

inline RenderSettings settings_of_all(int features = 0, const Conventions& conventions = {}) {
  RenderSettings settings;
  settings.conventions = conventions, settings.outputs = all_planes(features);
  return settings;
}

/// With depth along the ray.
inline Conventions along_ray(Conventions conventions = {}) {
  conventions.depth_at = Conventions::DepthAt::ray;
  return conventions;
}

/// White balls, whose alphas in the middle pixel of `middle_camera` are their opacities.
struct Ball {
  float depth, opacity;
};
inline Scene balls(const std::vector<Ball>& balls) {
  Scene scene;
  for (const Ball& ball : balls) append(scene, vec3(0, 0, ball.depth), 1, ball.opacity);
  return scene;
}
inline Camera middle_camera() {
  Camera camera = forward_camera(32, 32);
  camera.cx = camera.cy = 16.5;
  return camera;
}
inline constexpr std::size_t middle_pixel = 16 * 32 + 16;

/// Neither cuts alphas nor stops, so that binary fractions stay exact.
inline Conventions exact_conventions() {
  Conventions conventions;
  conventions.alpha_max = 1, conventions.stop = 0, conventions.stop_at_equal = false;
  return conventions;
}

/// Same planes but for the numbers of Gaussians.
inline bool same_but_ids(Frame a, Frame b) {
  a.id.clear(), a.median_id.clear(), b.id.clear(), b.median_id.clear();
  return same_planes(a, b);
}

/// Whether all planes that a frame has are those of another one.
inline bool same_of(const Frame& few, const Frame& whole) {
  bool same = true;
  for_each_plane([&](std::size_t, const auto& plane,
                     const auto& expected) { same = same && (plane.empty() || same_bits(plane, expected)); },
                 few, whole);
  return same;
}

/// What a frame may differ from the reference by where no decision is close.
struct PlaneBounds {
  double sum = 0;        ///< of alpha and normals, of features in parts of the largest, and thrice of colours
  double mean = 0;       ///< of depths, in parts of them
  double threshold = 0;  ///< alphas and transmittances this near their thresholds are close, in parts of them
  double pick = 0;       ///< so are weights and transmittances
  double picked = 1e-6;  ///< of depths of picked splats, in parts of them
  double least = 0;      ///< smaller depths are compared as parts of this one
  double occluder = 0;   ///< depths this near the occluder are close, in parts of them
};

/// Largest differences of sums and means from the reference, and pixels with close decisions.
struct PlaneErrors : PerPlane<double> {
  std::size_t wrong_picks = 0;
  std::size_t at_threshold = 0, at_first = 0, at_median = 0, at_id = 0, undecided_normals = 0;
};

/// Compares the first `frame.feature_channels` features.
inline PlaneErrors plane_errors(const Frame& frame, const ReferencePlanes& expected,
                                const PlaneBounds& bounds) {
  const std::size_t pixels = frame.pixels();
  REQUIRE(pixels == expected.pixels());
  REQUIRE(frame.feature_channels <= expected.feature_channels);
  for_each_plane([&]([[maybe_unused]] std::size_t channels,
                     [[maybe_unused]] const auto& values) { REQUIRE(values.size() == channels * pixels); },
                 frame);
  double most_feature = std::numeric_limits<double>::min();
  for (const double feature : expected.features) most_feature = std::max(most_feature, std::abs(feature));
  PlaneErrors out;
  for (std::size_t i = 0; i < pixels; ++i) {
    if (expected.threshold_margin[i] <= bounds.threshold || expected.occluder_margin[i] < bounds.occluder) {
      ++out.at_threshold;
      continue;
    }
    const double undecided = expected.undecided_normals[i];
    const bool first = !(expected.first_margin[i] > bounds.pick);
    const bool median = !(expected.median_margin[i] > bounds.pick);
    const bool id = expected.weight[i] != 0 && !(expected.weight[i] - expected.next_weight[i] > bounds.pick);
    out.undecided_normals += undecided > 0;
    out.at_first += first, out.at_median += median, out.at_id += id;
    const PerPlane<bool> close{.first_depth = first, .median_depth = median, .id = id, .median_id = median};
    const PerPlane<double> allowed{.normal = 2 * undecided};
    for_each_plane(
        [&](std::size_t, const PlaneRow& row, const auto& values, const auto& wanted_values, double& worst,
            bool is_close, double allowance) {
          const std::size_t channels = values.size() / pixels, stride = wanted_values.size() / pixels;
          for (std::size_t c = 0; c < channels; ++c) {
            const auto found = double(values[channels * i + c]);
            const auto wanted = double(wanted_values[stride * i + c]);
            const double apart = std::abs(found - wanted);
            if (row.accumulator == Accumulator::pick) {
              const double unit = row.length_power > 0 ? std::max(bounds.least, std::abs(wanted)) : 0;
              out.wrong_picks += !is_close && !(apart <= bounds.picked * unit);
              continue;
            }
            double unit = row.channels > 0 ? 1 : most_feature;
            if (row.accumulator == Accumulator::mean)
              unit = std::max({double(std::numeric_limits<float>::min()),
                               std::pow(bounds.least, row.length_power), std::abs(wanted)});
            const double error = (apart - allowance) / unit;
            worst = error >= 0 || error < 0 ? std::max(worst, error) : INFINITY;
          }
        },
        plane_table, frame, expected, out, close, allowed);
  }
  return out;
}

/// Checks sums and means.
inline void check_sums(const PlaneErrors& errors, [[maybe_unused]] const PlaneBounds& bounds) {
  for_each_plane(
      [&](std::size_t, [[maybe_unused]] const PlaneRow& row, [[maybe_unused]] double worst) {
        CAPTURE(row.name);
        [[maybe_unused]] const bool is_colour = row.name == std::string_view("colour");
        CHECK(worst <=
              (row.accumulator == Accumulator::mean ? bounds.mean : (is_colour ? 3 : 1) * bounds.sum));
      },
      plane_table, errors);
}

/// Checks colours and all planes of a frame before black, of whose pixels no more than a part `close` may be
/// set aside for each reason. Programs without doctest include this too: then nothing is checked.
inline void check_planes(const Frame& frame, const ReferencePlanes& expected, const PlaneBounds& bounds,
                         [[maybe_unused]] double close = 0.02) {
  const PlaneErrors errors = plane_errors(frame, expected, bounds);
  check_sums(errors, bounds);
  CHECK(errors.wrong_picks == 0);
  for ([[maybe_unused]] const std::size_t pixels :
       {errors.at_threshold, errors.at_first, errors.at_median, errors.at_id, errors.undecided_normals})
    CHECK(double(pixels) <= close * double(frame.pixels()));
}

/// What view `view` of the last frame shows at each pixel, picked in rectangles of odd sizes.
template <class B>
std::vector<PickedPixel> pick_all(BoundRenderer<B>& renderer, const Camera& camera, std::size_t view = 0) {
  std::vector<PickedPixel> all(std::size_t(camera.width) * std::size_t(camera.height));
  const int step_x = max_pick_side, step_y = 37;
  for (int y = 0; y < camera.height; y += step_y)
    for (int x = 0; x < camera.width; x += step_x) {
      const int width = std::min(step_x, camera.width - x), height = std::min(step_y, camera.height - y);
      const auto picked = renderer.pick({.x = x, .y = y, .width = width, .height = height, .view = view});
      REQUIRE(picked.size() == std::size_t(width) * std::size_t(height));
      for (int row = 0; row < height; ++row)
        std::copy_n(picked.data() + row * width, width, all.data() + (y + row) * camera.width + x);
    }
  return all;
}

}  // namespace swiftgs::test
