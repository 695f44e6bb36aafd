// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames that searches found, of one Gaussian each, for whatever backends the including file has. After
/// `sweep_cases.hpp`.

#include <swiftgs/stress/case.hpp>

#include "stability/sweep.hpp"

namespace swiftgs::test {
namespace {

/// One Gaussian in 16 x 16 pixels.
StressCase found_case(double fx, double fy, const stress::Gaussian& gaussian) {
  StressCase out;
  out.camera = stress::forward_camera({16, 16}, fx);
  out.camera.fy = fy;
  stress::add(out.scene, gaussian);
  return out;
}

/// Turns the camera of `drawn`; rows are the axes of the world as the camera sees them.
StressCase seen_by(StressCase drawn, const dmat3& rotation) {
  drawn.camera.rotation = rotation;
  return drawn;
}

TEST_CASE(SWIFTGS_STABILITY ": a disk eight times as wide as its depth is seen edge-on") {
  check_one(seen_by(found_case(42.00540541842998, 42.00540541842998,
                               {.mean = {14.724762f, -3.63998151f, -23.8882523f},
                                .scale = {227.921188f, 6.22205639f, 1.14952882e-05f},
                                .rotation = {0.355474472f, 0.798355758f, 0.113286033f, -0.472686261f},
                                .opacity = 0.940403938f}),
                    dmat3(dvec3(0.5928110536839577, -0.5945768668393017, 0.54318818474786),
                          dvec3(-0.695076900719958, -0.7183981997374278, -0.027787203881658257),
                          dvec3(0.4067470426636851, -0.36108499835022556, -0.8391510395934478))));
}

TEST_CASE(SWIFTGS_STABILITY ": a needle ten times as long as its depth points at the camera") {
  check_one(seen_by(found_case(40.8833050725891, 40.8833050725891,
                               {.mean = {-2.27965903f, -0.0808770284f, -7.10065556f},
                                .scale = {72.3398361f, 1.25452769f, 0.000798591995f},
                                .rotation = {-0.0099840546f, 0.808882475f, 0.0196996648f, 0.587555468f},
                                .opacity = 0.952097714f}),
                    dmat3(dvec3(0.05611012047848396, -0.9771675040843987, -0.2049276051227773),
                          dvec3(-0.9719655550404888, -0.10039910870384783, 0.21260992165538228),
                          dvec3(-0.22833005539071033, 0.18725300513727378, -0.9554065615602267))));
}

TEST_CASE(SWIFTGS_STABILITY ": a needle of six hundred thousand depths under uneven focal lengths") {
  check_one(seen_by(found_case(4.57207788717579, 4.784255767995087,
                               {.mean = {58.6094856f, 31.7088985f, -72.6000824f},
                                .scale = {31.0565014f, 14451780.0f, 0.123541936f},
                                .rotation = {-0.23145549f, -0.0102302497f, -0.506589711f, -0.830476105f},
                                .opacity = 0.499533921f}),
                    dmat3(dvec3(-0.3345891224730211, -0.9340498708265559, -0.12490379470467616),
                          dvec3(-0.023037469861439064, -0.12439606331017572, 0.9919651679445776),
                          dvec3(-0.9420824773368396, 0.3347782224724676, 0.020103423913802154))));
}

TEST_CASE(SWIFTGS_STABILITY ": a needle of three hundred thousand depths points at an ordinary lens") {
  check_one(found_case(7.24067233, 7.24067233,
                       {.mean = {-6.72712183f, 0.735681236f, 5.845397f},
                        .scale = {6.97249603f, 1.33409762f, 2169288.75f},
                        .rotation = {0.880127966f, -0.147736624f, -0.389019698f, 0.228500083f},
                        .opacity = 0.0961201563f}));
}

TEST_CASE(SWIFTGS_STABILITY ": a needle of a hundred thousand depths under hardly any blur") {
  StressCase drawn = found_case(8.5739519, 8.5739519,
                                {.mean = {31.3252411f, 10.6531324f, 28.8665504f},
                                 .scale = {0.471810818f, 4090760.25f, 41.2993011f},
                                 .rotation = {0.739910841f, 0.547459543f, 0.271738052f, -0.281030953f},
                                 .opacity = 0.0224179775f});
  drawn.conventions = Conventions::inria(), drawn.conventions.footprint = {};
  drawn.conventions.blur = 9.96720587e-07f;
  check_one(drawn);
}

TEST_CASE(SWIFTGS_STABILITY ": a blade of two million depths and a billionth thick") {
  check_one(found_case(17.9548438, 17.9548438,
                       {.mean = {-3.71621513f, -0.135017589f, 6.98651505f},
                        .scale = {10.0189581f, 17084222.0f, 2.00761696e-09f},
                        .rotation = {0.0771528259f, 0.260124743f, 0.708873153f, -0.651061714f},
                        .opacity = 0.465864152f}));
}

TEST_CASE(SWIFTGS_STABILITY ": a needle of a single depth points at a lens of a million pixels") {
  StressCase drawn = found_case(734773.647, 734773.647,
                                {.mean = {0.000346459448f, -0.000127906082f, 78.1707916f},
                                 .scale = {89.7003708f, 0.000161408185f, 1.03465927e-05f},
                                 .rotation = {0.0954564139f, -0.700638294f, -0.0954582095f, -0.700629592f},
                                 .opacity = 0.0552681684f});
  drawn.conventions = Conventions::inria(), drawn.conventions.footprint = {};
  drawn.conventions.blur = 6.9464113e-05f;
  check_one(drawn);
}

}  // namespace
}  // namespace swiftgs::test
