// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames of every renderer against the reference and each other, of whatever backends the including file
/// has. It defines SWIFTGS_PARITY, what the names of the cases begin with, and in `swiftgs::test` a function
/// `unavailable` that skips the case where the backends cannot run, and `backends`, their names.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <string>

#include <doctest/doctest.h>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/swiftgs.hpp>

#include "policies/planes.hpp"
#include "policies/rasterizers.hpp"

namespace swiftgs::test {
namespace {

constexpr bool on_device = backends[0] == "cuda";

/// Renders with all renderers and checks all that holds between them and the reference.
void check_all(const Scene& whole, const Camera& camera, Conventions conventions) {
  if (unavailable()) return;
  const auto scene = std::make_shared<const Scene>(with_features(whole, 2));
  RenderSettings settings;
  settings.conventions = conventions, settings.background = vec3(0.2f, 0.3f, 0.4f);
  settings.outputs = all_planes(2);
  const auto reference_of = [&](Conventions::Footprint footprint) {
    conventions.footprint = footprint;
    return render_reference(*scene, camera, conventions, dvec3(settings.background), 2);
  };
  const auto conservative = reference_of(Conventions::Footprint::alpha);
  const auto cut = reference_of(Conventions::Footprint::three_sigma_square);

  std::map<std::string, Frame> first_of;
  for (const RendererEntry& entry : renderers()) {
    const std::string name(entry.name), backend = name.substr(0, name.find('/'));
    if (std::find(std::begin(backends), std::end(backends), backend) == std::end(backends)) continue;
    CAPTURE(name);
    const auto renderer = entry.make();
    renderer->set_scene(scene);
    Frame frame, again;
    renderer->render(camera, settings, frame);
    renderer->render(camera, settings, again);
    CHECK(same_planes(again, frame));

    // Whatever the sort, and whatever the bounds as long as they are conservative, the bits are the same.
    const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
    const bool square = has("three-sigma-square"), half = has("half-split");
    const std::size_t raster = name.find('/', backend.size() + 1), bounds = name.rfind('/');
    const std::string group = backend + name.substr(raster, bounds - raster) + (square ? "/square" : "");
    const auto first = first_of.try_emplace(group, frame);
    CHECK(same_planes(first.first->second, frame));
    if (!first.second) continue;

    const ReferenceFrame& reference = square ? cut : conservative;
    // On a device split terms of floats err more where a warp block is far from the mean of a needle.
    const double least_db = half ? 40 : on_device && has("float-split") ? 105 : 120;
    CHECK(psnr(frame.colour, reference.colour) >= least_db);
    CHECK(psnr(frame.alpha, reference.alpha) >= least_db);
    if (!half) CHECK(max_abs_difference(frame.colour, reference.colour) <= 1.0 / 255);
    if (!half) CHECK(max_abs_difference(frame.alpha, reference.alpha) <= 1.0 / 255);
  }
  CHECK(first_of.size() == std::size(backends) * AllRasters::size * 2);
}

TEST_CASE(SWIFTGS_PARITY ": all renderers draw the reference's image for each SH degree") {
  for (const int degree : {0, 1, 2, 3}) {
    CAPTURE(degree);
    check_all(random_scene(on_device ? 400 : 250, degree, std::uint64_t(degree) + 1),
              on_device ? forward_camera(131, 77) : forward_camera(67, 45), Conventions::gsplat());
  }
}

TEST_CASE(SWIFTGS_PARITY ": all renderers draw the reference's image with the inria preset") {
  check_all(random_scene(on_device ? 600 : 400, 3, 5), forward_camera(97, 61), Conventions::inria());
}

TEST_CASE(SWIFTGS_PARITY ": all renderers draw the reference's image with depths along the ray") {
  check_all(random_scene(300, 0, 8), forward_camera(67, 45), along_ray());
}

TEST_CASE(SWIFTGS_PARITY ": all renderers draw the reference's image in the antialiased mode") {
  Scene scene = random_scene(600, 1, 6);
  for (vec3& scale : scene.scales) scale *= 0.3f;  // a pixel or less, where it matters
  for (Conventions conventions : {Conventions::gsplat(), Conventions::inria()}) {
    conventions.antialiased = true;
    check_all(scene, forward_camera(80, 60), conventions);
  }
}

TEST_CASE(SWIFTGS_PARITY ": all renderers draw the reference's image with a principal point outside of it") {
  Camera camera = forward_camera(64, 48);
  camera.cx = -20, camera.cy = 70;
  check_all(random_scene(400, 2, 7), camera, Conventions::gsplat());
}

TEST_CASE(SWIFTGS_PARITY ": all renderers draw the reference's image of the built-in scene") {
  if constexpr (on_device)
    check_all(make_builtin_scene(8000), builtin_camera(192, 108), Conventions::gsplat());
  else
    check_all(make_builtin_scene(4000), builtin_camera(128, 72), Conventions::gsplat());
}

}  // namespace
}  // namespace swiftgs::test
