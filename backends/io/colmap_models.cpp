// SPDX-License-Identifier: Apache-2.0
#include "colmap_models.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "camera_parsing.hpp"
#include "listed.hpp"
#include "tokens.hpp"

namespace swiftgs::io {
namespace {

constexpr std::string_view never = ColmapModel::never;

/// In the order of COLMAP's numbers. EUCM is a pinhole where alpha is 0, whatever beta is.
constexpr ColmapModel models[] = {{"SIMPLE_PINHOLE", 3, 1, ""},
                                  {"PINHOLE", 4, 2, ""},
                                  {"SIMPLE_RADIAL", 4, 1, "k"},
                                  {"RADIAL", 5, 1, "k1 k2"},
                                  {"OPENCV", 8, 2, "k1 k2 p1 p2"},
                                  {"OPENCV_FISHEYE", 8, 2, never},
                                  {"FULL_OPENCV", 12, 2, "k1 k2 p1 p2 k3 k4 k5 k6"},
                                  {"FOV", 5, 2, "omega"},
                                  {"SIMPLE_RADIAL_FISHEYE", 4, 1, never},
                                  {"RADIAL_FISHEYE", 5, 1, never},
                                  {"THIN_PRISM_FISHEYE", 12, 2, never},
                                  {"RAD_TAN_THIN_PRISM_FISHEYE", 16, 2, never},
                                  {"SIMPLE_DIVISION", 4, 1, "k"},
                                  {"DIVISION", 5, 2, "k"},
                                  {"SIMPLE_FISHEYE", 3, 1, never},
                                  {"FISHEYE", 4, 2, never},
                                  {"EUCM", 6, 2, "alpha"},
                                  {"EQUIRECTANGULAR", 2, 0, never}};

dmat3 rotation_of(const Source& images, std::uint64_t offset, const ColmapPose& pose) {
  const double length = std::sqrt(pose.w * pose.w + pose.x * pose.x + pose.y * pose.y + pose.z * pose.z);
  if (!(length > 0) || !std::isfinite(length))
    images.fail(offset, "a quaternion with a finite length above 0");
  const double w = pose.w / length, x = pose.x / length, y = pose.y / length, z = pose.z / length;
  return {dvec3(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
          dvec3(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
          dvec3(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))};
}

}  // namespace

const ColmapModel* colmap_model(std::int32_t id) {
  return id >= 0 && id < std::ssize(models) ? &models[id] : nullptr;
}

const ColmapModel* colmap_model(std::string_view name) {
  const auto* found = std::find_if(std::begin(models), std::end(models),
                                   [&](const ColmapModel& model) { return model.name == name; });
  return found == std::end(models) ? nullptr : found;
}

void set_intrinsics(Camera& camera, const ColmapModel& model, std::span<const double> parameters,
                    const Source& source, std::uint64_t offset) {
  if (model.zeros == ColmapModel::never) refuse_model(source, offset, model.name);
  const double* value = &parameters[std::size_t(model.focal_lengths) + 1];
  for (Tokens names(model.zeros); !names.at_end();)
    if (const std::string_view name = names.next(); *++value != 0)
      refuse_model(source, offset, std::string(model.name) + " with " + coefficient(name, *value));
  camera.fx = parameters[0], camera.fy = parameters[model.focal_lengths - 1];
  camera.cx = parameters[model.focal_lengths], camera.cy = parameters[model.focal_lengths + 1];
}

void refuse_model(const Source& source, std::uint64_t offset, std::string_view found) {
  source.fail(
      offset,
      "a pinhole of undistorted images (PINHOLE, SIMPLE_PINHOLE, or a model whose coefficients are all "
      "0), found " +
          std::string(found));
}

std::string coefficient(std::string_view name, const nlohmann::json& value) {
  return std::string(name) + (value.is_primitive() ? " = " + listed({value.dump()}) : " that is not 0");
}

void ColmapCameras::add(std::uint32_t id, std::uint64_t offset) {
  if (!offsets_.emplace(id, offset).second)
    source_.fail(offset, "each camera id once, found " + std::to_string(id) + " again");
}

Camera ColmapCameras::place(const Source& images, std::uint64_t offset, const ColmapPose& pose,
                            std::string_view name) const {
  const auto found = offsets_.find(pose.camera_id);
  if (found == offsets_.end())
    images.fail(offset, "the id of a known camera, found " + std::to_string(pose.camera_id));
  Camera camera = read_(source_, found->second);
  camera.name = name;
  camera.rotation = rotation_of(images, offset, pose);
  camera.translation = pose.translation;
  expect_valid(images, offset, camera);
  return camera;
}

}  // namespace swiftgs::io
