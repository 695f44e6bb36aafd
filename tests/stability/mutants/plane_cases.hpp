// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Planes that a device draws, beside the reference.

#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/frame_planes.hpp>

#include "cuda/device.hpp"
#include "policies/planes.hpp"
#include "policies/random_splats.hpp"
#include "stability/sweep.hpp"

namespace swiftgs::test {
namespace {

/// A scene with what is asked of it.
struct PlaneTrial {
  Scene scene;
  Camera camera;
  Conventions conventions{};
  std::vector<float> occluder{};

  Frame drawn(bool counted = false) const {
    Renderer<Cuda, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer;
    RenderSettings settings = settings_of_all(scene.feature_channels, conventions);
    settings.count = counted;
    Frame frame;
    FrameView view = prepare(frame, camera.width, camera.height, settings.outputs);
    FramePlanes<Cuda> planes;
    planes.reset(settings.outputs, frame.pixels());
    planes.place(view, 0);
    DeviceBuffer<float> depths;
    if (!occluder.empty()) {
      copy_to_device(Span<const float>{occluder.data(), occluder.size()}, depths);
      view.occluder = {depths.data(), std::ptrdiff_t(sizeof(float)) * camera.width};
    }
    const auto uploaded = renderer.backend().upload(scene);
    renderer.render_into(uploaded.view(), camera, settings, view);
    for_each_plane([&](std::size_t, const auto& plane,
                       auto& values) { renderer.backend().download(plane.span(), values.data()); },
                   planes, frame);
    return frame;
  }
};

/// Rounding alone reaches half of these.
void check(const PlaneTrial& trial) {
  const ReferencePlanes expected = render_reference_planes(trial.scene, trial.camera, trial.conventions, 0,
                                                           {trial.occluder.data(), trial.occluder.size()});
  check_planes(trial.drawn(), expected,
               {.sum = 6e-5,
                .mean = 2.4e-4,
                .threshold = 1e-4,
                .pick = 1e-5,
                .picked = 1e-5,
                .least = 1,
                .occluder = 1e-5},
               0.05);
}

/// Layers in front of a small image, so many that warps share its lists. All are faint but the first and one
/// in the middle: where these are wide, that one takes the transmittance below one half and has the largest
/// weight.
PlaneTrial long_lists(double least_size, double most_size) {
  PlaneTrial trial{{}, forward_camera(32, 32)};
  trial.conventions.alpha_min = 2e-5f;
  Random random(3);
  for (int i = 0; i < 6000; ++i) {
    const float y = random.f(-0.2, 0.2), x = random.f(-0.2, 0.2),
                size = float(random.scale(least_size, most_size));
    const double faint = random.scale(1e-4, 3e-4);
    const float opacity = i == 0 ? 0.1f : i == 3000 ? 0.6f : float(faint);
    append(trial.scene, vec3(x, y, 2 + float(i) / 1000), size, opacity);
  }
  return trial;
}

}  // namespace

TEST_CASE(SWIFTGS_STABILITY " planes: each is that of the reference") {
  if (unavailable()) return;
  Conventions along_ray;
  along_ray.depth_at = Conventions::DepthAt::ray;
  const Scene sparse = random_scene(400, 1, 5), dense = make_builtin_scene(20'000);
  const Camera camera = forward_camera(67, 45), of_dense = scaled(builtin_camera(), 0.1);
  std::vector<float> occluder;
  for (int i = 0; i < camera.width * camera.height; ++i)
    occluder.push_back(2 + 2.5f * (1 + std::sin(0.3f * float(i % camera.width) + 0.01f * float(i))));
  for (const Conventions& conventions : {Conventions(), along_ray})
    for (const int features : {0, 1, 5, 20}) {
      CAPTURE(features);
      check({with_features(sparse, features), camera, conventions});
      check({with_features(dense, features), of_dense, conventions});
      check({with_features(sparse, features), camera, conventions, occluder});
    }
}

TEST_CASE(SWIFTGS_STABILITY " planes: lists of segments pick as short ones do") {
  if (unavailable()) return;
  PlaneTrial trial = long_lists(10, 10);
  trial.drawn(true);  // its list is cut into segments
  trial.scene = with_features(trial.scene, 3);
  check(trial);
}

TEST_CASE(SWIFTGS_STABILITY
          " planes: an occluder ends pixels of long lists where it ends those of counted frames") {
  if (unavailable()) return;
  // Counted frames blend splats one by one, others in groups.
  PlaneTrial trial = long_lists(0.03, 0.3);
  Random random(4);
  for (int i = 0; i < trial.camera.width * trial.camera.height; ++i) trial.occluder.push_back(random.f(2, 8));
  const Frame frame = trial.drawn(), counted = trial.drawn(true);
  CHECK(same_bits(frame.alpha, counted.alpha));
  CHECK(same_bits(frame.colour, counted.colour));
  // The same where occluders are at the depths of splats.
  for (float& depth : trial.occluder) depth = 2 + std::floor(1000 * (depth - 2)) / 1000;
  CHECK(same_bits(trial.drawn().alpha, trial.drawn(true).alpha));
}

TEST_CASE(SWIFTGS_STABILITY " planes: of equal weights the nearest and of halves the next") {
  if (unavailable()) return;
  PlaneTrial trial{{}, forward_camera(32, 32)};
  trial.camera.cx = trial.camera.cy = 16.5;
  trial.conventions.alpha_max = 1, trial.conventions.stop = 0, trial.conventions.stop_at_equal = false;
  append(trial.scene, vec3(0, 0, 2), 1, 0.5f);
  append(trial.scene, vec3(0, 0, 3), 1, 1);
  const Frame frame = trial.drawn();
  const std::size_t middle = 16 * 32 + 16;
  CHECK(frame.id[middle] == 0);
  CHECK(frame.median_id[middle] == 1);
  CHECK(frame.median_depth[middle] == 3);
}

}  // namespace swiftgs::test
