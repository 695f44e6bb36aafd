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

constexpr LensModel perspective = LensModel::perspective, fisheye = LensModel::fisheye;

/// In the order of COLMAP's numbers. Its k4 to k6 of FULL_OPENCV are rational. EUCM is a pinhole where alpha
/// is 0, whatever beta is.
constexpr ColmapModel models[] = {{"SIMPLE_PINHOLE", 3, 1, perspective, ""},
                                  {"PINHOLE", 4, 2, perspective, ""},
                                  {"SIMPLE_RADIAL", 4, 1, perspective, "k1"},
                                  {"RADIAL", 5, 1, perspective, "k1 k2"},
                                  {"OPENCV", 8, 2, perspective, "k1 k2 p1 p2"},
                                  {"OPENCV_FISHEYE", 8, 2, fisheye, "k1 k2 k3 k4"},
                                  {"FULL_OPENCV", 12, 2, perspective, "k1 k2 p1 p2 k3 q1 q2 q3"},
                                  {"FOV", 5, 2, perspective, "omega"},
                                  {"SIMPLE_RADIAL_FISHEYE", 4, 1, fisheye, "k1"},
                                  {"RADIAL_FISHEYE", 5, 1, fisheye, "k1 k2"},
                                  {"THIN_PRISM_FISHEYE", 12, 2, fisheye, "k1 k2 p1 p2 k3 k4 s1 s2"},
                                  {"RAD_TAN_THIN_PRISM_FISHEYE", 16, 2, {}, ""},
                                  {"SIMPLE_DIVISION", 4, 1, perspective, "k"},
                                  {"DIVISION", 5, 2, perspective, "k"},
                                  {"SIMPLE_FISHEYE", 3, 1, {}, ""},
                                  {"FISHEYE", 4, 2, {}, ""},
                                  {"EUCM", 6, 2, perspective, "alpha"},
                                  {"EQUIRECTANGULAR", 2, 0, {}, ""}};

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

double* coefficient_of(Distortion& distortion, std::string_view name) {
  if (name.size() != 2 || name[1] < '1') return nullptr;
  const int at = name[1] - '1';
  switch (name[0]) {
    case 'k':
      return at < 4 ? &distortion.radial[at] : nullptr;
    case 'q':
      return at < 3 ? &distortion.rational[at] : nullptr;
    case 'p':
      return at < 2 ? &distortion.tangential[at] : nullptr;
    case 's':
      return at < 2 ? &distortion.prism[at] : nullptr;
    default:
      return nullptr;
  }
}

void set_intrinsics(Camera& camera, const ColmapModel& model, std::span<const double> parameters,
                    const Source& source, std::uint64_t offset) {
  if (!model.lens) refuse_model(source, offset, model.name);
  camera.fx = parameters[0], camera.fy = parameters[model.focal_lengths - 1];
  camera.cx = parameters[model.focal_lengths], camera.cy = parameters[model.focal_lengths + 1];
  camera.lens.model = *model.lens;
  const double* value = &parameters[std::size_t(model.focal_lengths) + 2];
  for (Tokens names(model.coefficients); !names.at_end(); ++value) {
    const std::string_view name = names.next();
    if (double* const coefficient = coefficient_of(camera.lens.distortion, name))
      *coefficient = *value;
    else if (*value != 0)
      refuse_model(source, offset, std::string(model.name) + " with " + named_coefficient(name, *value));
  }
}

void refuse_model(const Source& source, std::uint64_t offset, std::string_view found, std::string_view more) {
  std::string expected =
      "one of the camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, "
      "OPENCV_FISHEYE, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, THIN_PRISM_FISHEYE";
  source.fail(offset, expected.append(more).append(", found ").append(found));
}

std::string named_coefficient(std::string_view name, const nlohmann::json& value) {
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
