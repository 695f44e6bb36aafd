// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Scenes of long lists, what frames of them may ask for, and whether warps shared their lists.

#include <cstddef>
#include <utility>
#include <vector>

#include <swiftgs/tools/policy_lists.hpp>

#include "cuda/device.hpp"
#include "policies/rasterizers.hpp"
#include "policies/views.hpp"
#include "state.hpp"

namespace swiftgs::test {

/// Faint Gaussians, one behind the other, that reach over much of an image: pixels stop at very different
/// places of very long lists.
inline Scene layers(std::size_t count, double faintest, double densest) {
  Random random(count);
  Scene scene = random_scene(count, 0, count);
  for (std::size_t i = 0; i < count; ++i) {
    const float z = 2 + 8 * float(i) / float(count), side = 0.5f * z;
    const float x = random.f(-side, side), y = random.f(-side, side);
    scene.means[i] = vec3(x, y, z);
    const float wide = random.f(0.1 * z, 0.8 * z), narrow = random.f(0.1 * z, 0.8 * z);
    scene.scales[i] = vec3(wide, narrow, 0.01f);
    scene.opacities[i] = float(random.scale(faintest, densest));
  }
  return scene;
}

/// Keeps Gaussians that are much fainter than those that frames usually show, so that lists of ten thousands
/// are needed to stop a pixel. Kernels blend a single view in groups down to about this alpha.
inline Conventions faint() {
  Conventions conventions;
  conventions.alpha_min = 2e-5f;
  return conventions;
}

inline Camera square_camera(int side) {
  Camera camera = forward_camera(side, side, side);
  camera.cx = camera.cy = 0.5 * side;
  return camera;
}

/// Planes that are drawn by kernels of their own.
struct Wanted {
  const char* name;
  bool depth = false, occluder = false;
  Outputs further{};
  bool along_ray = false;
};
inline std::vector<Wanted> wanted_planes() {
  const auto with_picks = [](Outputs of) {
    of.first_depth = of.median_depth = of.id = of.median_id = true;
    return of;
  };
  const Outputs picks = with_picks({}), row{.normal = true},
                rows{.squared_depth = true, .normal = true, .features = 7};
  Outputs rays = with_picks(rows);
  rays.features = 4;  // 16 attributes: they are summed at once
  return {{"colour"},
          {"depth", true, true},
          {"picks", false, true, picks},
          {"a row", false, true, row},
          {"rows", true, true, rows},
          {"picks and a row", true, false, with_picks(row)},
          {"picks and rows", true, true, with_picks(rows)},
          {"picks along the ray", false, true, picks, true},
          {"all along the ray", true, true, rays, true}};
}

/// Such an image before white.
inline AskedView square_view(int side, const Wanted& wanted, const Conventions& conventions) {
  AskedView view{square_camera(side), conventions, vec3(1)};
  view.depth = wanted.depth, view.occluder = wanted.occluder, view.further = wanted.further;
  if (wanted.along_ray) view.conventions.depth_at = Conventions::DepthAt::ray;
  return view;
}

/// Rasterizers that cut lists into segments.
using Segmented = TypeList<AxisSharedThreshold<FloatCholesky>, AxisShared<FloatCholesky>,
                           AxisSharedThreshold<FloatSplit>, AxisShared<FloatSplit>>;

/// Calls f(renderer) for each of them.
template <class F>
void for_each_segmented(const F& f) {
  for_each_type(Segmented(), [&]<class Raster>(Raster) {
    CAPTURE(Raster::name);
    f(Usual<Cuda, EarlySort, Raster>());
  });
}

/// Whether the helper kernel had work items in the last frame that started it.
inline bool was_shared(const Cuda& cuda) {
  return to_host(cuda, std::as_const(RasterMemory::of(cuda).word).span()).at(0) == 0;
}

}  // namespace swiftgs::test
