// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames over ranks against those of one renderer. All ranks run tests side by side, so nothing may throw on
/// one rank alone.

#include <cstddef>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/mpi.hpp>
#include <swiftgs/swiftgs.hpp>

#include "mpi/ranks_here.hpp"
#include "policies/all_planes.hpp"

namespace swiftgs::test {

inline ScenePart own_part() { return {std::size_t(ranks_here().rank()), std::size_t(ranks_here().size())}; }

/// Cameras of unlike sizes; none is a multiple of 16.
inline std::vector<Camera> some_cameras() {
  std::vector<Camera> cameras = builtin_cameras(3, 125, 71);
  cameras[1] = scaled(cameras[1], 0.31);
  cameras.push_back(builtin_camera(167, 85));
  return cameras;
}

/// The built-in scene all around the camera.
inline Camera builtin_panorama() {
  Camera camera = builtin_camera(256, 128);
  camera.lens.model = LensModel::equirectangular;
  camera.fx = camera.width / 6.283185307179586, camera.fy = 2 * camera.height / 6.283185307179586;
  return camera;
}

inline RenderSettings all_outputs() { return settings_of({true, true}, vec3(0.1f, 0.2f, 0.3f)); }

/// With 14 features.
inline Scene with_features(Scene scene) {
  scene.feature_channels = 14;
  for (std::size_t i = 0; i < 14 * scene.size(); ++i) scene.features.push_back(float(i * 37 % 101) / 50 - 1);
  return scene;
}

/// Every plane of such a scene: the 16 attributes that are summed together, and two more.
inline RenderSettings every_plane() { return settings_of(all_planes(14), all_outputs().background); }

/// Whether `found` and `expected` have the same planes in the rows of `strip`.
inline bool same_rows(const Frame& found, const Frame& expected, const ViewStrip& strip) {
  bool same = true;
  for_each_plane(
      [&](std::size_t channel_count, const auto& a, const auto& b) {
        const std::size_t row = channel_count * std::size_t(found.width);
        const std::size_t first = row * std::size_t(strip.first_row), size = row * std::size_t(strip.rows);
        same = same && a.size() == b.size() &&
               (a.empty() || std::memcmp(&a[first], &b[first], size * sizeof a[0]) == 0);
      },
      found, expected);
  return same;
}

/// The message of what f() throws on this rank: `failing` throws its own `Error`, the others are told of it.
template <class Error = std::exception, class F>
std::string message_of(int failing, const F& f) {
  try {
    f();
  } catch (const RankError& error) {
    CHECK(ranks_here().rank() != failing);
    CHECK(error.rank() == failing);
    return error.what();
  } catch (const Error& error) {
    CHECK(ranks_here().rank() == failing);
    return error.what();
  }
  return {};
}

/// Renders `cameras` in one frame, several times, so that strips move, and compares it with one renderer of
/// the whole scene on the backend `One`. `own` is this rank's part.
template <class B, class Sort, class Raster, class Bounds, class One = B>
void compare(const Scene& scene, const Scene& own, const std::vector<Camera>& cameras, int frames = 3,
             const RenderSettings& settings = all_outputs()) {
  const Span<const Camera> all{cameras.data(), cameras.size()};
  std::vector<Frame> expected(cameras.size()), found(cameras.size());
  Renderer<One, Sort, Raster, Bounds> one;
  const auto whole = one.backend().upload(scene);
  DistributedRenderer<B, Sort, Raster, Bounds> distributed(ranks_here());
  const auto part = distributed.backend().upload(own);
  CAPTURE(distributed.name);
  for (int k = 0; k < frames; ++k) {
    one.render(whole, all, settings, {expected.data(), expected.size()});
    distributed.render(part.view(), all, settings, {found.data(), found.size()});
    if (ranks_here().rank() == 0)
      for (std::size_t i = 0; i < cameras.size(); ++i) CHECK(same_planes(found[i], expected[i]));
  }
  CHECK(distributed.counters().visible() == one.statistics().visible);
  CHECK(distributed.counters().intersections() == one.statistics().intersections);
}

template <class B, class Sort, class Raster, class Bounds, class One = B>
void compare(const Scene& scene, const std::vector<Camera>& cameras, int frames = 3) {
  compare<B, Sort, Raster, Bounds, One>(scene, part_of(scene, own_part()), cameras, frames);
}

/// f.operator()<Sort, Raster, Bounds>() with each of them.
template <class F>
void for_every_policy(const F& f) {
  f.template operator()<EarlySort, PerPixel, ThreeSigmaSquare>();
  f.template operator()<StandardSort, AxisShared<FloatCholesky>, OpacityBox>();
  f.template operator()<AdaptiveSort, AxisShared<FloatSplit>, Obb>();
  f.template operator()<EarlySort, AxisShared<HalfSplit>, Ellipse>();
  f.template operator()<EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse>();
  f.template operator()<StandardSort, AxisSharedThreshold<FloatSplit>, ThreeSigmaSquare>();
  f.template operator()<AdaptiveSort, AxisSharedThreshold<HalfSplit>, Obb>();
}

/// `compare` with each sort, rasterizer and bounds. `part` is this rank's of `scene`.
void compare_every_policy(const Scene& scene, const Scene& part, const std::vector<Camera>& cameras);

}  // namespace swiftgs::test
