// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/stress.hpp>
#include <swiftgs/tools/split_mix.hpp>

/// @file
/// Frames that are hard for float arithmetic: tests and `swiftgs stress` draw them.

namespace swiftgs {

/// A frame that is hard on arithmetic.
struct StressCase {
  Scene scene;
  Camera camera;
  Conventions conventions;
  vec3 background{0.25f};
  std::vector<float> occluder;    ///< @shape{height, width} as `FrameView::occluder`, or empty
  Similarity world_from_scene{};  ///< where the scene is placed
  Clip clip{};                    ///< what of it shows
};

/// What frames of `drawn` are judged by.
inline ConditionedFrame render_conditioned(const StressCase& drawn, const StressTrials& trials = {},
                                           int threads = 0) {
  const ReferenceScene placed{drawn.scene, drawn.world_from_scene, 1, drawn.clip};
  return render_conditioned({&placed, 1}, drawn.camera, drawn.conventions, dvec3(drawn.background), trials,
                            threads, {drawn.occluder.data(), drawn.occluder.size()});
}

/// Size of an image. @units{pixels}
struct ImageSize {
  int width = 64, height = 48;
};

/// A kind of hard frame, at every severity. `make` is a function of its arguments alone.
struct StressFamily {
  std::string_view name;      ///< kebab-case
  std::string_view severity;  ///< what its numbers are, as an axis is labelled
  std::vector<double> severities;
  StressCase (*make)(double severity, std::uint64_t seed, ImageSize size);
};

namespace stress {

/// Numbers that depend on the seed alone, on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed * SplitMix64::step + 0x632be59bd9b4e019u) {}

  double in(double low, double high) { return low + (high - low) * bits_.uniform(); }
  float f(double low, double high) { return float(in(low, high)); }
  double scale(double low, double high) { return std::exp(in(std::log(low), std::log(high))); }
  int below(int count) { return int(bits_.bits() % std::uint64_t(count)); }

  /// A point in [low, high)^3, drawn in declarations: arguments in parentheses have no order, so that
  /// compilers would draw other frames.
  dvec3 point(double low, double high) {
    const double z = in(low, high), y = in(low, high), x = in(low, high);
    return {x, y, z};
  }

  /// A unit quaternion, as exactly as floats hold one.
  Quaternion rotation() {
    double q[4], squares = 0;
    do {
      squares = 0;
      for (double& v : q) v = in(-1, 1), squares += v * v;
    } while (squares > 1 || squares < 0.01);
    const double length = std::sqrt(squares);
    return {float(q[0] / length), float(q[1] / length), float(q[2] / length), float(q[3] / length)};
  }

 private:
  SplitMix64 bits_;
};

/// (x, y, distance), with x and y in [-distance, distance).
inline dvec3 distant_point(Random& random, double distance) {
  const double y = distance * random.in(-1, 1), x = distance * random.in(-1, 1);
  return {x, y, distance};
}

/// A camera at the origin that looks along +z, `focal` pixels long, its axis in the middle of the image.
inline Camera forward_camera(ImageSize size, double focal) {
  Camera camera;
  camera.fx = camera.fy = focal;
  camera.cx = 0.5 * size.width, camera.cy = 0.5 * size.height;
  camera.width = size.width, camera.height = size.height;
  return camera;
}

/// The focal length that shows 64 degrees across.
inline double usual_focal(ImageSize size) { return 0.8 * size.width; }

/// One Gaussian of a scene.
struct Gaussian {
  vec3 mean{0, 0, 2}, scale{0.1f};
  Quaternion rotation{};
  float opacity = 0.5f;
  vec3 rgb{1, 1, 1};
};

/// Adds `g` to `scene`, with no view-dependent colour.
inline void add(Scene& scene, const Gaussian& g) {
  scene.means.push_back(g.mean), scene.scales.push_back(g.scale);
  scene.rotations.push_back(g.rotation), scene.opacities.push_back(g.opacity);
  scene.sh0.push_back((g.rgb - 0.5f) * (1 / 0.28209479177387814f));
  scene.sh_rest.resize(scene.size() * 3 * std::size_t(sh_rest_count(scene.sh_degree)));
}

inline vec3 random_colour(Random& random) { return {random.f(0, 1), random.f(0, 1), random.f(0, 1)}; }

/// A point that the camera of `usual_focal` sees at depth z, somewhat beyond the borders too.
inline vec3 point_in_view(Random& random, ImageSize size, double z) {
  const double tan_x = 0.5 * size.width / usual_focal(size), tan_y = tan_x * size.height / size.width;
  return {float(random.in(-1.1, 1.1) * tan_x * z), float(random.in(-1.1, 1.1) * tan_y * z), float(z)};
}

/// A Gaussian of the sizes that trained scenes have, a few to some tens of pixels.
inline Gaussian usual_gaussian(Random& random, ImageSize size) {
  const double z = random.in(2, 10), pixel = z / usual_focal(size);
  const auto side = [&] { return float(pixel * random.scale(0.3, 12)); };
  return {.mean = point_in_view(random, size, z),
          .scale = {side(), side(), side()},
          .rotation = random.rotation(),
          .opacity = float(random.scale(0.02, 1)),
          .rgb = random_colour(random)};
}

/// A case of `count` usual Gaussians, with harmonics of degree `degree`.
inline StressCase usual_case(Random& random, ImageSize size, int count = 60, int degree = 1) {
  StressCase out;
  out.camera = forward_camera(size, usual_focal(size));
  out.scene.sh_degree = degree;
  for (int i = 0; i < count; ++i) add(out.scene, usual_gaussian(random, size));
  for (float& value : out.scene.sh_rest) value = random.f(-0.1, 0.1);
  return out;
}

/// Turns the camera of `drawn` at the origin by `angle` and some more, and the means with it.
inline void turn(StressCase& drawn, double angle) {
  const Camera upright = drawn.camera;
  drawn.camera = look_at(dvec3(0), dvec3(std::sin(angle), 0.3, std::cos(angle)), dvec3(0.1, -1, 0.2), 0.9,
                         upright.width, upright.height);
  drawn.camera.fx = upright.fx, drawn.camera.fy = upright.fy;
  drawn.camera.cx = upright.cx, drawn.camera.cy = upright.cy;
  for (vec3& mean : drawn.scene.means) {
    // To where the turned camera sees them.
    const vec3 p = mean;
    for (int k = 0; k < 3; ++k) {
      const dvec3 column = drawn.camera.rotation[k];
      mean[k] = float(column.x * double(p.x) + column.y * double(p.y) + column.z * double(p.z));
    }
  }
}

}  // namespace stress
}  // namespace swiftgs
