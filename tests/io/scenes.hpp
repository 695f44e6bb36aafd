// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <vector>

#include <swiftgs/io/scene_file.hpp>

#include "files.hpp"

namespace swiftgs::test {

inline SceneFile read(const std::string& content, const std::string& name = "a file",
                      const SceneReadOptions& options = {}) {
  return read_scene(as_bytes(content), name, options);
}

inline std::string complaint_about(const std::string& content, const std::string& name = "a file") {
  return complaint([&] { read(content, name); });
}

inline std::string all_notes(const std::vector<std::string>& notes) {
  std::string all;
  for (const std::string& note : notes) all += note + "\n";
  return all;
}

/// A scene of arbitrary legal Gaussians, the same every time.
inline Scene some_scene(std::size_t count, int sh_degree) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-1, 1);
  Scene scene;
  scene.sh_degree = sh_degree;
  for (std::size_t i = 0; i < count; ++i) {
    const auto three = [&] { return vec3(value(random), value(random), value(random)); };
    scene.means.push_back(5.0f * three());
    const vec3 log_scale = 3.0f * three();
    scene.scales.emplace_back(std::exp(log_scale.x), std::exp(log_scale.y), std::exp(log_scale.z));
    const vec4 q(value(random), three());
    const float length = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    scene.rotations.push_back({q.x / length, q.y / length, q.z / length, q.w / length});
    scene.opacities.push_back(0.5f + 0.49f * value(random));
    scene.sh0.push_back(three());
    for (int k = 0; k < 3 * sh_rest_count(sh_degree); ++k) scene.sh_rest.push_back(0.9f * value(random));
  }
  return scene;
}

/// By what `b` differs from `a`, whichever of its two signs it has: w, x, y and z.
inline std::array<double, 4> rotation_errors(const Quaternion& a, const Quaternion& b) {
  const double product = double(a.w) * b.w + double(a.x) * b.x + double(a.y) * b.y + double(a.z) * b.z;
  const double sign = product < 0 ? -1 : 1;
  return {a.w - sign * b.w, a.x - sign * b.x, a.y - sign * b.y, a.z - sign * b.z};
}

/// Which of w, x, y and z is the largest.
inline std::size_t largest_of(const Quaternion& q) {
  const std::array<float, 4> sizes{std::abs(q.w), std::abs(q.x), std::abs(q.y), std::abs(q.z)};
  return std::size_t(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
}

/// The largest differences between two scenes of the same Gaussians in one order.
struct Difference {
  double means = 0, sh0 = 0, band_1 = 0, sh_rest = 0, opacities = 0;
  double scales = 0;     ///< of logarithms
  double rotations = 0;  ///< of four numbers, whose common sign means nothing
};

/// `b` is what was read.
inline Difference difference(const Scene& a, const Scene& b) {
  REQUIRE(a.size() == b.size());
  REQUIRE(a.sh_degree == b.sh_degree);
  CHECK_NOTHROW(validate(b));
  Difference most;
  const auto take = [](double& largest, double x, double y) {
    const double apart = x == y ? 0 : std::abs(x - y);
    if (!(apart <= largest)) largest = std::isnan(apart) ? INFINITY : apart;
  };
  const std::size_t rest = 3 * std::size_t(sh_rest_count(a.sh_degree));
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      take(most.means, a.means[i][axis], b.means[i][axis]);
      take(most.sh0, a.sh0[i][axis], b.sh0[i][axis]);
      take(most.scales, std::log(double(a.scales[i][axis])), std::log(double(b.scales[i][axis])));
    }
    take(most.opacities, a.opacities[i], b.opacities[i]);
    for (std::size_t k = 0; k < rest; ++k)
      take(k < 9 ? most.band_1 : most.sh_rest, a.sh_rest[i * rest + k], b.sh_rest[i * rest + k]);
    const auto [w, x, y, z] = rotation_errors(a.rotations[i], b.rotations[i]);
    take(most.rotations, std::hypot(std::hypot(w, x), std::hypot(y, z)), 0);
  }
  most.sh_rest = std::max(most.sh_rest, most.band_1);
  return most;
}

/// Checks that `a`, which was read, is `b`, but for the rounding of rotations.
inline void check_same(const Scene& a, const Scene& b) {
  CHECK(a.means == b.means);
  CHECK(a.scales == b.scales);
  CHECK(a.opacities == b.opacities);
  CHECK(a.sh0 == b.sh0);
  CHECK(a.sh_rest == b.sh_rest);
  CHECK(difference(b, a).rotations < 1e-6);
}

/// Checks that a file holds `stored` Gaussians of `format`, all read, with nothing to note.
inline void check_whole(const SceneFile& file, const std::string& format, std::size_t stored) {
  CHECK(file.format == format);
  CHECK(file.stored == stored);
  CHECK(file.left_out.total() == 0);
  CHECK(file.notes.empty());
}

/// What a `Progress` was told.
struct Listener {
  std::vector<double> told{};

  Progress progress() {
    return [this](double part) { return told.push_back(part), true; };
  }

  void check_whole() const {
    REQUIRE(told.size() >= 2);
    CHECK(told.front() == 0);
    CHECK(told.back() == 1);
    CHECK(std::is_sorted(told.begin(), told.end()));
  }
};

/// A scene that was written, and what was read of it.
struct Written : WrittenScene {
  std::string content{};
  SceneFile file{};

  const Scene& scene() const { return file.scene; }
};

/// Writes `scene` and reads the file. Checks that the file holds what the writer reports. Unless the scene is
/// empty, the progress of both goes from 0 to 1.
inline Written write_and_read(const Scene& scene, const std::string& ending, SceneWriteOptions options = {}) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / ("a" + ending);
  Listener writing, reading;
  options.progress = writing.progress();
  Written written{write_scene(path, scene, options), content_of(path), {}};
  written.file = read_scene(path, {.spz_frame = options.spz_frame, .progress = reading.progress()});
  if (scene.size() > 0) writing.check_whole(), reading.check_whole();
  check_whole(written.file, written.format, written.gaussians);
  CHECK(written.bytes == written.content.size());
  CHECK(written.gaussians == written.scene().size());
  CHECK(written.sh_degree == written.scene().sh_degree);
  CHECK(written.model == written.scene().model);
  return written;
}

/// R diag(s^2) R^T of Gaussian `i`.
inline dmat3 covariance(const Scene& scene, std::size_t i) {
  const auto [qw, qx, qy, qz] = scene.rotations[i];
  const double w = qw, x = qx, y = qy, z = qz;
  const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                          {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                          {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  dmat3 result(0);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (int k = 0; k < 3; ++k) result[a][b] += r[a][k] * r[b][k] * std::pow(double(scene.scales[i][k]), 2);
  return result;
}

/// Checks that the covariance of Gaussian `i` of `moved` is that of `scene` after a linear map.
inline void check_moved_covariance(const Scene& moved, const Scene& scene, std::size_t i,
                                   const dmat3& linear) {
  const dmat3 expected = linear * covariance(scene, i) * glm::transpose(linear), found = covariance(moved, i);
  const double size = expected[0][0] + expected[1][1] + expected[2][2];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) CHECK(std::abs(found[a][b] - expected[a][b]) < 1e-6 * size);
}

}  // namespace swiftgs::test
