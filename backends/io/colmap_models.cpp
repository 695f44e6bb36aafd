// SPDX-License-Identifier: Apache-2.0
#include "colmap_models.hpp"

#include <iterator>
#include <string>

namespace swiftgs::io {
namespace {

/// In the order of COLMAP's numbers.
constexpr std::string_view names[] = {"SIMPLE_PINHOLE",
                                      "PINHOLE",
                                      "SIMPLE_RADIAL",
                                      "RADIAL",
                                      "OPENCV",
                                      "OPENCV_FISHEYE",
                                      "FULL_OPENCV",
                                      "FOV",
                                      "SIMPLE_RADIAL_FISHEYE",
                                      "RADIAL_FISHEYE",
                                      "THIN_PRISM_FISHEYE",
                                      "RAD_TAN_THIN_PRISM_FISHEYE",
                                      "SIMPLE_DIVISION",
                                      "DIVISION",
                                      "SIMPLE_FISHEYE",
                                      "FISHEYE",
                                      "EUCM",
                                      "EQUIRECTANGULAR"};

}  // namespace

ColmapModel colmap_model(const Source& source, std::uint64_t offset, std::int32_t id) {
  if (id >= 0 && id < std::ssize(names)) return colmap_model(source, offset, names[id]);
  return colmap_model(source, offset, std::string_view("number " + std::to_string(id)));
}

ColmapModel colmap_model(const Source& source, std::uint64_t offset, std::string_view name) {
  if (name == "SIMPLE_PINHOLE") return {.parameters = 3};
  if (name == "PINHOLE") return {.parameters = 4};
  refuse_model(source, offset, name);
}

void refuse_model(const Source& source, std::uint64_t offset, std::string_view found) {
  source.fail(offset,
              "camera model PINHOLE or SIMPLE_PINHOLE (undistorted images), found " + std::string(found));
}

}  // namespace swiftgs::io
