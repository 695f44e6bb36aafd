// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Scenes of a few Gaussians that a fuzzer found, each reduced. For whatever backends the including file has,
/// as in `sweep_cases.hpp`.

#include <string_view>
#include <vector>

#include "stability/edge_cases.hpp"
#include "stability/number_cases.hpp"
#include "stability/sweep.hpp"

namespace swiftgs::test {
namespace {

/// A frame of a few Gaussians, and what is hard about it.
struct FoundFrame {
  std::string_view what;
  Camera camera;
  std::vector<StressGaussian> gaussians;
  Conventions conventions{};
};

void check_found(const std::vector<FoundFrame>& frames, Extent extent) {
  for (const FoundFrame& found : frames) {
    CAPTURE(found.what);
    StressCase drawn;
    drawn.camera = found.camera, drawn.conventions = found.conventions;
    for (const StressGaussian& g : found.gaussians) stress::add(drawn.scene, g);
    check_drawn(drawn, extent);
  }
}

/// Rows of `rotation` are the axes of the world as the camera sees them.
Camera found_camera(ImageSize size, double fx, double fy, double cx, double cy,
                    const dmat3& rotation = dmat3(1.0)) {
  Camera camera;
  camera.fx = fx, camera.fy = fy, camera.cx = cx, camera.cy = cy;
  camera.width = size.width, camera.height = size.height;
  camera.rotation = rotation;
  return camera;
}

const vec3 black(-0.1f);  // cut at 0

TEST_CASE(SWIFTGS_STABILITY ": scenes of a few Gaussians that a fuzzer found") {
  const ImageSize size{32, 24};
  check_found(
      {{"a line passes so far from its mean that the last place of its slope shows",
        found_camera(size, 0.0471965979, 0.0160325582, 13.5, 11),
        {{.mean = {-347.589661f, -835.756287f, 1.26991022f},
          .scale = {283543.719f, 0, 0},
          .rotation = {0.86454457f, 0, -0.502555132f, -0.00100215652f},
          .opacity = 0.5f}}},
       {"means are a million pixels away",
        found_camera(size, 5.08458244, 5.08458244, 11, 4.5),
        {{.mean = {485514048, 484932128, 349644.031f},
          .scale = {3.47096346e+09f, 3.47096346e+09f, 0},
          .rotation = {0.80363059f, -0.408507377f, -0.408507377f, 0.142903313f},
          .opacity = 1,
          .rgb = black},
         {.mean = {-81000704, -2550.448f, 1766.4303f},
          .scale = {0, 18789094, 18789094},
          .rotation = {0.876979411f, 0.277432948f, 0.277432948f, 0.277432948f},
          .rgb = black}}},
       {"of a disk seen edge-on, the row of y and the rows' cross product are small by cancellation",
        found_camera(size, 10691.0119, 10691.0119, 5, 11.5),
        {{.mean = {-2564483.25f, 20.2945328f, 38981.1289f},
          .scale = {1650769.88f, 1650769.88f, 0},
          .rotation = {0.592617989f, -0.592599869f, 0.385765016f, 0.385765016f},
          .opacity = 1}}},
       {"a background shows behind black splats",
        found_camera(size, 10691.0119, 10691.0119, 5, 11.5),
        {{.mean = {-0.00249474868f, -0.0026081102f, 3.03061247f},
          .scale = {0.373522758f, 0, 0},
          .rotation = {0.469060123f, 0.381835282f, 0.344332755f, -0.0891182423f},
          .rgb = black},
         {.mean = {-0.00249474868f, -0.0026081102f, 3.03061247f},
          .scale = {102200, 0.100718386f, 0},
          .rotation = {0.639154553f, -0.444027573f, -0.444027573f, -0.444027573f},
          .opacity = 1,
          .rgb = black}}},
       {"depths are ten million apart",
        found_camera(size, 8854.43687, 8854.43687, 9, 9.5),
        {{.mean = {2.17496245e-06f, -7.26789949e-05f, 0.096845977f},
          .scale = vec3(0),
          .rotation = {0.478995472f, 0.127008408f, 0.325671226f, 0.524334013f},
          .opacity = 0.0155903343f},
         {.mean = {2.17496245e-06f, -7.26789949e-05f, 0.096845977f},
          .scale = {0.0179523323f, 0, 2932.05811f},
          .rotation = {0.938227892f, -0.313810796f, -0.143163547f, 0.0274837073f},
          .opacity = 1},
         {.mean = {-1882.73328f, -3393.22607f, 1891467}, .scale = {4562704.5f, 1.84394586e+09f, 0}}}}},
      Extent::all);
}

TEST_CASE(SWIFTGS_STABILITY ": transmittances keep their digits behind four black splats") {
  for (const float opacity : {1.0f, 0.983f, 0.97f, 0.6f}) {
    CAPTURE(opacity);
    stress::Random random(1);
    StressCase drawn = stress::usual_case(random, {96, 64}, 20);
    for (vec3& mean : drawn.scene.means) mean *= 4.0f;
    for (vec3& scale : drawn.scene.scales) scale *= 4.0f;
    drawn.conventions.stop = 1e-9f;
    for (int i = 0; i < 4; ++i) {
      StressGaussian g = stress::flat_gaussian(random, {96, 64}, random.f(1, 3), opacity);
      g.rgb = black;
      stress::add(drawn.scene, g);
    }
    check_drawn(drawn);
  }
}

}  // namespace
}  // namespace swiftgs::test
