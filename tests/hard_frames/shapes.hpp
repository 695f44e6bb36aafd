// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "hard_frames/case.hpp"

/// @file
/// Families of hard shapes.

namespace swiftgs::stress {

/// `usual` usual Gaussians and `hard` that `change` makes hard.
template <class Change>
StressCase shaped_case(std::uint64_t seed, ImageSize size, int usual, int hard, const Change& change) {
  Random random(seed);
  StressCase out = usual_case(random, size, usual);
  for (int i = 0; i < hard; ++i) {
    Gaussian g = usual_gaussian(random, size);
    change(random, g);
    add(out.scene, g);
  }
  return out;
}

/// Long thin Gaussians among usual ones; severity: length over width.
inline StressCase needles(double condition, std::uint64_t seed, ImageSize size) {
  return shaped_case(seed, size, 10, 50, [=](Random& random, Gaussian& g) {
    g.mean = point_in_view(random, size, random.in(2, 6));
    const double length = random.in(1, 10);
    g.scale = {float(length), float(length / condition), float(length / condition * random.in(0.5, 1))};
  });
}

/// The same without blur, which bounds how thin a splat is; severity: length over width.
inline StressCase bare_needles(double condition, std::uint64_t seed, ImageSize size) {
  StressCase out = needles(condition, seed, size);
  out.conventions.blur = 0;
  return out;
}

/// Flat Gaussians; severity: side over thickness.
inline StressCase pancakes(double condition, std::uint64_t seed, ImageSize size) {
  return shaped_case(seed, size, 10, 40, [=](Random& random, Gaussian& g) {
    const double side = random.in(0.2, 3);
    g.scale = {float(side), float(side * random.in(0.3, 1)), float(side / condition)};
  });
}

/// Splats many images long and some pixels wide, at 45 degrees, their means in or near the image; severity:
/// standard deviation along. @units{pixels}
inline StressCase ridges(double sigma, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size, 10);
  for (int i = 0; i < 12; ++i) {
    const double z = random.in(2, 4), pixel = z / usual_focal(size);
    const double turn = (i % 2 ? 0.5 : -0.5) * (0.7853981633974483 + random.in(-0.01, 0.01));
    vec3 mean = point_in_view(random, size, z);
    if (i % 3 == 2) mean = mean * 5.0f, mean.z = float(z);
    add(out.scene, {.mean = mean,
                    .scale = {float(sigma * pixel), float(random.scale(0.3, 30) * pixel), float(pixel)},
                    .rotation = {float(std::cos(turn)), 0, 0, float(std::sin(turn))},
                    .opacity = random.f(0.3, 1),
                    .rgb = random_colour(random)});
  }
  return out;
}

/// Gaussians that reach the camera's plane; severity: standard deviation over depth.
inline StressCase grazing(double ratio, std::uint64_t seed, ImageSize size) {
  return shaped_case(seed, size, 10, 30, [=](Random& random, Gaussian& g) {
    const double z = random.scale(0.011, 1);
    g.mean = point_in_view(random, size, z) * vec3(2, 2, 1);
    for (int k = 0; k < 3; ++k) g.scale[k] = float(z * ratio * random.in(0.2, 1));
    g.opacity = random.f(0.02, 0.4);
  });
}

/// Scales of every size; severity: the largest, the least is its inverse to the third, but above 1e-45.
inline StressCase scales(double largest, std::uint64_t seed, ImageSize size) {
  const double least = std::fmax(std::pow(largest, -3), 1e-45);
  return shaped_case(seed, size, 10, 50, [=](Random& random, Gaussian& g) {
    for (int k = 0; k < 3; ++k) g.scale[k] = float(random.scale(least, largest));
    g.opacity = random.f(0.02, 0.5);
  });
}

/// Means far off screen of splats that reach into the image; severity: distance. @units{pixels}
inline StressCase distant_means(double distance, std::uint64_t seed, ImageSize size) {
  Random random(seed);
  StressCase out = usual_case(random, size, 20);
  for (int i = 0; i < 30; ++i) {
    const double z = random.in(2, 6), pixel = z / usual_focal(size), angle = random.in(0, 6.283185307179586);
    Gaussian g = usual_gaussian(random, size);
    g.mean =
        vec3(float(distance * pixel * std::cos(angle)), float(distance * pixel * std::sin(angle)), float(z));
    g.scale = {float(distance * pixel * random.in(0.3, 1)), float(distance * pixel * random.in(0.01, 1)),
               float(pixel)};
    // Ridges through the image. Beyond 1e6 pixels a mean's last place is wider than they are.
    if (i % 3 == 0 && distance <= 1e6) g.scale.y = float(pixel * random.in(1, 5));
    g.rotation = {float(std::cos(0.5 * angle)), 0, 0, float(std::sin(0.5 * angle))};
    g.opacity = random.f(0.1, 0.8);
    add(out.scene, g);
  }
  return out;
}

/// Splats under ever less blur; severity: the inverse of the blur, infinity for none. @units{1/pixels^2}
inline StressCase little_blur(double inverse, std::uint64_t seed, ImageSize size) {
  StressCase out = shaped_case(seed, size, 30, 60, [=](Random& random, Gaussian& g) {
    const double pixel = double(g.mean.z) / usual_focal(size);
    for (int k = 0; k < 3; ++k) g.scale[k] = float(random.scale(0.02, 20) * pixel);
  });
  out.conventions.blur = float(1 / inverse);
  out.conventions.antialiased = seed % 2;
  return out;
}

}  // namespace swiftgs::stress
