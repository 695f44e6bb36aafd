// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames that a fuzzer and searches found, each reduced. For whatever backends the including file has, as in
/// `sweep_cases.hpp`.

#include <string_view>
#include <vector>

#include "stability/number_cases.hpp"

namespace swiftgs::test {
namespace {

/// A frame of a few Gaussians, and what is hard about it.
struct FoundFrame {
  std::string_view what;
  Camera camera;
  std::vector<stress::Gaussian> gaussians;
  Conventions conventions{};
};

void check_found(const std::vector<FoundFrame>& frames, Extent extent) {
  for (const FoundFrame& found : frames) {
    CAPTURE(found.what);
    StressCase drawn;
    drawn.camera = found.camera, drawn.conventions = found.conventions;
    for (const stress::Gaussian& g : found.gaussians) stress::add(drawn.scene, g);
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

Conventions with_blur(float blur, bool antialiased = false, Conventions conventions = {}) {
  conventions.footprint = {}, conventions.blur = blur, conventions.antialiased = antialiased;
  return conventions;
}

TEST_CASE(SWIFTGS_STABILITY ": single Gaussians that searches found") {
  const ImageSize size{16, 16};
  check_found(
      {{"a disk eight times as wide as its depth is seen edge-on",
        found_camera(size, 42.00540541842998, 42.00540541842998, 8, 8,
                     dmat3(dvec3(0.5928110536839577, -0.5945768668393017, 0.54318818474786),
                           dvec3(-0.695076900719958, -0.7183981997374278, -0.027787203881658257),
                           dvec3(0.4067470426636851, -0.36108499835022556, -0.8391510395934478))),
        {{.mean = {14.724762f, -3.63998151f, -23.8882523f},
          .scale = {227.921188f, 6.22205639f, 1.14952882e-05f},
          .rotation = {0.355474472f, 0.798355758f, 0.113286033f, -0.472686261f},
          .opacity = 0.940403938f}}},
       {"a needle ten times as long as its depth points at the camera",
        found_camera(size, 40.8833050725891, 40.8833050725891, 8, 8,
                     dmat3(dvec3(0.05611012047848396, -0.9771675040843987, -0.2049276051227773),
                           dvec3(-0.9719655550404888, -0.10039910870384783, 0.21260992165538228),
                           dvec3(-0.22833005539071033, 0.18725300513727378, -0.9554065615602267))),
        {{.mean = {-2.27965903f, -0.0808770284f, -7.10065556f},
          .scale = {72.3398361f, 1.25452769f, 0.000798591995f},
          .rotation = {-0.0099840546f, 0.808882475f, 0.0196996648f, 0.587555468f},
          .opacity = 0.952097714f}}},
       {"a needle of six hundred thousand depths under uneven focal lengths",
        found_camera(size, 4.57207788717579, 4.784255767995087, 8, 8,
                     dmat3(dvec3(-0.3345891224730211, -0.9340498708265559, -0.12490379470467616),
                           dvec3(-0.023037469861439064, -0.12439606331017572, 0.9919651679445776),
                           dvec3(-0.9420824773368396, 0.3347782224724676, 0.020103423913802154))),
        {{.mean = {58.6094856f, 31.7088985f, -72.6000824f},
          .scale = {31.0565014f, 14451780.0f, 0.123541936f},
          .rotation = {-0.23145549f, -0.0102302497f, -0.506589711f, -0.830476105f},
          .opacity = 0.499533921f}}},
       {"a needle of three hundred thousand depths points at an ordinary lens",
        found_camera(size, 7.24067233, 7.24067233, 8, 8),
        {{.mean = {-6.72712183f, 0.735681236f, 5.845397f},
          .scale = {6.97249603f, 1.33409762f, 2169288.75f},
          .rotation = {0.880127966f, -0.147736624f, -0.389019698f, 0.228500083f},
          .opacity = 0.0961201563f}}},
       {"a needle of a hundred thousand depths under hardly any blur",
        found_camera(size, 8.5739519, 8.5739519, 8, 8),
        {{.mean = {31.3252411f, 10.6531324f, 28.8665504f},
          .scale = {0.471810818f, 4090760.25f, 41.2993011f},
          .rotation = {0.739910841f, 0.547459543f, 0.271738052f, -0.281030953f},
          .opacity = 0.0224179775f}},
        with_blur(9.96720587e-07f, false, Conventions::inria())},
       {"a blade of two million depths and a billionth thick",
        found_camera(size, 17.9548438, 17.9548438, 8, 8),
        {{.mean = {-3.71621513f, -0.135017589f, 6.98651505f},
          .scale = {10.0189581f, 17084222.0f, 2.00761696e-09f},
          .rotation = {0.0771528259f, 0.260124743f, 0.708873153f, -0.651061714f},
          .opacity = 0.465864152f}}},
       {"a needle of a single depth points at a lens of a million pixels",
        found_camera(size, 734773.647, 734773.647, 8, 8),
        {{.mean = {0.000346459448f, -0.000127906082f, 78.1707916f},
          .scale = {89.7003708f, 0.000161408185f, 1.03465927e-05f},
          .rotation = {0.0954564139f, -0.700638294f, -0.0954582095f, -0.700629592f},
          .opacity = 0.0552681684f}},
        with_blur(6.9464113e-05f, false, Conventions::inria())},
       {"a needle of six hundred thousand depths under hardly any blur",
        found_camera(size, 11.855630316397358, 3.7304474607144078, 8, 8,
                     dmat3(dvec3(-0.13583759480460933, 0.93654870733855322, -0.32314805681016234),
                           dvec3(-0.97411698041484707, -0.18573843358796371, -0.12883067474693344),
                           dvec3(-0.18067721578870799, 0.29728396033216248, 0.93753826088542436))),
        {{.mean = {7.50387478f, 0.162397861f, 9.14385414f},
          .scale = {6196411.5f, 0.122796983f, 30790.1836f},
          .rotation = {0.903909206f, -0.0103693381f, -0.427590221f, 0.00268842629f},
          .opacity = 0.384487122f}},
        with_blur(3.48281297e-08f)},
       {"a needle of five depths beside the first row of an image",
        found_camera({40, 24}, 54.268168156529093, 54.268168156529093, 19.999975471134441,
                     0.93488399060908689,
                     dmat3(dvec3(0.90108852620617441, -0.27946629503801468, 0.33156908462236034),
                           dvec3(-0.4100107421228687, -0.30015453922641044, 0.86127721665305634),
                           dvec3(-0.14117598692213584, -0.91203390425987274, -0.38504999441248455))),
        {{.mean = {0.00846857205f, 3.04592013f, -1.01829517f},
          .scale = {0.000215488602f, 3.8743062f, 20.6286602f},
          .rotation = {0.58298254f, -0.812483847f, 0.000767956488f, -0.000845556322f},
          .opacity = 0.928718686f}},
        with_blur(0.000671027577f, true)},
       {"a disk seven hundred focal lengths off the axis is compensated for its width",
        found_camera(size, 0.017121364814206855, 0.017121364814206855, 8, 8,
                     dmat3(dvec3(0, 1, 0), dvec3(1, 0, 0), dvec3(0, 0, -1))),
        {{.mean = {2105.53613f, 973.013794f, -3.35509109f},
          .scale = {3.9406882e-06f, 7.21360016f, 3.17682028f},
          .rotation = {-0.165313855f, -0.529265463f, -0.808405638f, 0.197559506f},
          .opacity = 0.959827363f}},
        with_blur(5.48764001e-05f, true)},
       {"a disk twenty billion times as wide as its depth is seen edge-on",
        found_camera(size, 11.565209883990281, 11.565209883990281, 1.1777047508988499, 7.9999690844200888,
                     dmat3(dvec3(-0.59473633905486967, 0.74091574586017728, -0.31198164135741707),
                           dvec3(0.79745336637656783, 0.49458943512972087, -0.34561455280810011),
                           dvec3(-0.10176844040413713, -0.45434034400933471, -0.88499606572187006))),
        {{.mean = {-4.03880548f, -0.00864559691f, -4.61738873f},
          .scale = {1.05364185e+11f, 0.365659177f, 1281287.88f},
          .rotation = {0.00910208281f, -0.910579145f, -0.00490574911f, -0.413205385f},
          .opacity = 0.00497382693f}},
        with_blur(0, true)}},
      Extent::rasterizers);
}

}  // namespace
}  // namespace swiftgs::test
