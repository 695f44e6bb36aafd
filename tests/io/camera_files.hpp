// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/io/cameras.hpp>
#include <swiftgs/lens/point.hpp>

#include "camera_parsing.hpp"
#include "files.hpp"

/// @file
/// COLMAP models in memory, as a test puts them together, and where lenses show points.

namespace swiftgs::test {

/// Width, height, focal lengths and principal point.
using Intrinsics = std::vector<double>;

inline Intrinsics intrinsics(const Camera& c) {
  return {double(c.width), double(c.height), c.fx, c.fy, c.cx, c.cy};
}

inline void check_intrinsics(const Camera& camera, const Intrinsics& expected) {
  for (std::size_t i = 0; i < 6; ++i) CHECK(intrinsics(camera)[i] == doctest::Approx(expected[i]));
}

struct ColmapCamera {
  std::uint32_t id = 1;
  std::int32_t model = 1;
  std::uint64_t width = 640, height = 480;
  std::vector<double> parameters = {500, 510, 321, 239};
};

struct ColmapImage {
  std::string name = "a.jpg";
  std::uint32_t camera_id = 1;
  double pose[7] = {2, 0, 0, 2, 1, 2, 3};  ///< 90 degrees about z, not of unit length
  std::uint64_t points = 2, stored_points = 2;
};

inline std::string cameras_bin(const std::vector<ColmapCamera>& cameras) {
  std::string file;
  append(file, std::uint64_t(cameras.size()));
  for (const ColmapCamera& c : cameras) {
    append(file, c.id), append(file, c.model), append(file, c.width), append(file, c.height);
    for (const double p : c.parameters) append(file, p);
  }
  return file;
}

inline std::string images_bin(const std::vector<ColmapImage>& images) {
  std::string file;
  append(file, std::uint64_t(images.size()));
  for (const ColmapImage& image : images) {
    append(file, std::uint32_t(7));
    for (const double p : image.pose) append(file, p);
    append(file, image.camera_id);
    file += image.name + '\0';
    append(file, image.points);
    file += std::string(24 * image.stored_points, 'p');
  }
  return file;
}

inline std::vector<Camera> parse_binary(const std::string& cameras, const std::string& images) {
  return io::parse_colmap_binary({as_bytes(cameras), "cameras.bin"}, {as_bytes(images), "images.bin"});
}

inline std::vector<Camera> parse_text(const std::string& cameras, const std::string& images) {
  return io::parse_colmap_text({as_bytes(cameras), "cameras.txt"}, {as_bytes(images), "images.txt"});
}

struct Pixel {
  double x, y;
};

/// What the lens of `camera` makes of a point of camera space.
inline Pixel shown_by(const Camera& camera, const dvec3& p) {
  const LensPoint at = point_through(camera.lens, {}, p);
  return {camera.fx * at.u + camera.cx, camera.fy * at.v + camera.cy};
}

inline void check_pixel(const Camera& camera, const dvec3& p, Pixel expected) {
  CAPTURE(p.x);
  CAPTURE(p.y);
  const Pixel shown = shown_by(camera, p);
  CHECK(shown.x == doctest::Approx(expected.x).epsilon(1e-12));
  CHECK(shown.y == doctest::Approx(expected.y).epsilon(1e-12));
}

}  // namespace swiftgs::test
