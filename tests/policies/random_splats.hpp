// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Reproducible random splats, Gaussians and cameras.

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs::test {

/// Numbers that are the same on every machine (xorshift64*). Draw them in statements of their own: compilers
/// evaluate the arguments of a call in different orders.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 1) {}

  std::uint64_t bits() {
    state_ ^= state_ >> 12, state_ ^= state_ << 25, state_ ^= state_ >> 27;
    return state_ * 0x2545f4914f6cdd1du;
  }
  double in(double low, double high) { return low + (high - low) * (double(bits() >> 11) * 0x1p-53); }
  /// Even over orders of magnitude.
  double scale(double low, double high) { return std::exp(in(std::log(low), std::log(high))); }
  float f(double low, double high) { return float(in(low, high)); }

 private:
  std::uint64_t state_;
};

/// The splat of a given ellipse: standard deviations `along` and `across` @units{pixels}, the first turned by
/// `angle` from the x axis.
inline SplatShape make_splat(double x, double y, double along, double across, double angle, double opacity,
                             double alpha_min = 1.0 / 255) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double yy = along * along * s * s + across * across * c * c;
  const double xy = (along * along - across * across) * c * s;
  const double det = along * along * across * across;
  const double base_2 = std::sqrt(0.5 * log2_e);
  SplatShape shape;
  shape.set_mean(x, y);
  shape.l0 = float(base_2 * std::sqrt(yy / det));
  shape.l1 = float(-base_2 * std::sqrt(yy / det) * xy / yy);
  shape.l2 = float(base_2 / std::sqrt(yy));
  shape.opacity = float(opacity);
  shape.cutoff = float(std::log2(opacity / alpha_min));
  return shape;
}

/// Anything that projection may emit for an image of `width` x `height`: sub-pixel dots (blurred to 0.55
/// pixels), needles, giants, centres outside the image, opacities from the threshold to 1.
inline SplatShape random_splat(Random& random, int width, int height) {
  const double across = random.scale(0.5478, 300);
  const double along = across * random.scale(1, 1e4);
  const double margin = 0.6 * along < 2.0 * width ? 0.6 * along : 2.0 * width;
  const double opacity = random.scale(1.0 / 254, 1), angle = random.in(0, 3.14159265);
  const double y = random.in(-margin, height + margin), x = random.in(-margin, width + margin);
  return make_splat(x, y, along, across, angle, opacity);
}

/// As `random_splat`, of sizes that trained scenes have.
inline SplatShape usual_splat(Random& random, int width, int height) {
  const double across = random.scale(0.5478, 12);
  const double opacity = random.scale(1.0 / 200, 1), angle = random.in(0, 3.14159265);
  const double along = across * random.scale(1, 8);
  const double y = random.in(-20, height + 20), x = random.in(-20, width + 20);
  return make_splat(x, y, along, across, angle, opacity);
}

/// Looks along +z from the origin; the principal point lies off the centre.
inline Camera forward_camera(int width, int height, double focal = 0) {
  Camera camera;
  camera.fx = focal > 0 ? focal : 0.9 * width;
  camera.fy = focal > 0 ? focal : 0.95 * width;
  camera.cx = 0.5 * width + 2.3, camera.cy = 0.5 * height - 1.7;
  camera.width = width, camera.height = height;
  return camera;
}

inline Quaternion random_rotation(Random& random) {
  double q[4], squares = 0;
  do {
    squares = 0;
    for (double& v : q) v = random.in(-1, 1), squares += v * v;
  } while (squares > 1 || squares < 1e-3);
  const double inverse = 1 / std::sqrt(squares);
  return {float(q[0] * inverse), float(q[1] * inverse), float(q[2] * inverse), float(q[3] * inverse)};
}

/// `count` Gaussians in and around the view of `forward_camera`, some behind it, some needles and flakes.
inline Scene random_scene(std::size_t count, int sh_degree, std::uint64_t seed) {
  Random random(seed);
  Scene scene;
  scene.sh_degree = sh_degree;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = random.in(-1, 12);
    const float y = random.f(-1, 1) * float(std::abs(z)) * 0.7f;
    const float x = random.f(-1, 1) * float(std::abs(z)) * 0.7f;
    scene.means.push_back(vec3(x, y, float(z)));
    const double size = random.scale(0.005, 0.5);
    const float third = float(size * random.scale(0.02, 1)), second = float(size * random.scale(0.02, 1));
    scene.scales.push_back(vec3(float(size), second, third));
    scene.rotations.push_back(random_rotation(random));
    scene.opacities.push_back(float(random.scale(0.003, 1)));
    const float blue = random.f(-1.5, 1.5), green = random.f(-1.5, 1.5), red = random.f(-1.5, 1.5);
    scene.sh0.push_back(vec3(red, green, blue));
    for (int k = 0; k < 3 * sh_rest_count(sh_degree); ++k) scene.sh_rest.push_back(random.f(-0.3, 0.3));
  }
  return scene;
}

/// `scene` with features of its own for each Gaussian.
inline Scene with_features(Scene scene, int channels, std::uint64_t seed = 1) {
  Random random(seed);
  scene.feature_channels = channels;
  scene.features.resize(scene.size() * std::size_t(channels));
  for (float& feature : scene.features) feature = random.f(-2, 2);
  return scene;
}

/// Adds a white ball.
inline void append(Scene& scene, vec3 mean, float scale, float opacity) {
  scene.means.push_back(mean), scene.scales.push_back(vec3(scale)), scene.rotations.push_back({});
  scene.opacities.push_back(opacity), scene.sh0.push_back(vec3(1));
}

/// Gaussians that each cover any image.
inline Scene giants_of(int count) {
  Scene scene;
  for (int i = 0; i < count; ++i) append(scene, vec3(0, 0, 1), 1000, 1);
  return scene;
}

}  // namespace swiftgs::test
