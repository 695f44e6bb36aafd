// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "camera_parsing.hpp"
#include "files.hpp"

/// @file
/// COLMAP models in memory, as a test puts them together.

namespace swiftgs::test {

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

}  // namespace swiftgs::test
