// SPDX-License-Identifier: Apache-2.0
#include "colmap_models.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "camera_parsing.hpp"
#include "text.hpp"

namespace swiftgs::io {
namespace {

constexpr LensModel perspective = LensModel::perspective, fisheye = LensModel::fisheye,
                    equirectangular = LensModel::equirectangular;

/// In the order of COLMAP's numbers. THIN_PRISM_FISHEYE has all names that mean the same in several models.
constexpr ColmapModel models[] = {{"SIMPLE_PINHOLE", 3, 1, perspective, ""},
                                  {"PINHOLE", 4, 2, perspective, ""},
                                  {"SIMPLE_RADIAL", 4, 1, perspective, "k:k1"},
                                  {"RADIAL", 5, 1, perspective, "k1 k2"},
                                  {"OPENCV", 8, 2, perspective, "k1 k2 p1 p2"},
                                  {"OPENCV_FISHEYE", 8, 2, fisheye, "k1 k2 k3 k4"},
                                  {"FULL_OPENCV", 12, 2, perspective, "k1 k2 p1 p2 k3 k4:q1 k5:q2 k6:q3"},
                                  {"FOV", 5, 2, perspective, "omega:"},
                                  {"SIMPLE_RADIAL_FISHEYE", 4, 1, fisheye, "k:k1"},
                                  {"RADIAL_FISHEYE", 5, 1, fisheye, "k1 k2"},
                                  {"THIN_PRISM_FISHEYE", 12, 2, fisheye, "k1 k2 p1 p2 k3 k4 sx1:s1 sy1:s2"},
                                  {"RAD_TAN_THIN_PRISM_FISHEYE", 16, 2, fisheye,
                                   "k0:k1 k1:k2 k2:k3 k3:k4 k4: k5: p0:p2 p1:p1 s0:s1 s1: s2:s2 s3:", true},
                                  {"SIMPLE_DIVISION", 4, 1, perspective, "k:"},
                                  {"DIVISION", 5, 2, perspective, "k:"},
                                  {"SIMPLE_FISHEYE", 3, 1, fisheye, ""},
                                  {"FISHEYE", 4, 2, fisheye, ""},
                                  {"EUCM", 6, 2, perspective, "alpha:"},
                                  {"EQUIRECTANGULAR", 2, 0, equirectangular, ""}};

/// A word of `ColmapModel::coefficients`.
struct Coefficient {
  std::string_view name, slot;
};

Coefficient next_coefficient(Tokens& words) {
  const std::string_view word = words.next();
  const std::size_t colon = word.find(':');
  return {word.substr(0, colon), colon == word.npos ? word : word.substr(colon + 1)};
}

double* slot_of(Distortion& distortion, std::string_view slot) {
  if (slot.empty()) return nullptr;
  const int at = slot[1] - '1';
  switch (slot[0]) {
    case 'k':
      return &distortion.radial[at];
    case 'q':
      return &distortion.rational[at];
    case 'p':
      return &distortion.tangential[at];
    default:
      return &distortion.prism[at];
  }
}

/// Whether the model is read whatever its coefficients.
bool is_always_read(const ColmapModel& model) {
  for (Tokens words(model.coefficients); !words.at_end();)
    if (next_coefficient(words).slot.empty()) return false;
  return !model.moves_twice;
}

/// Makes `camera` what two models are for some coefficients that `Distortion` has no place for. EUCM is a
/// pinhole where beta is 0. FOV is an equidistant fisheye lens where 2 tan(omega / 2) is 1 or -1.
bool set_special_case(Camera& camera, const ColmapModel& model, std::span<const double> numbers) {
  if (model.name == "EUCM") return std::isfinite(numbers[0]) && numbers[1] == 0;
  const double omega = std::abs(numbers[0]);
  if (model.name != "FOV" || !(std::abs(2 * std::tan(omega / 2) - 1) < 1e-12) || omega > 1) return false;
  camera.lens.model = fisheye;
  camera.fx /= omega, camera.fy /= omega;
  return true;
}

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
  if (name == "SPHERICAL") name = "EQUIRECTANGULAR";  // as forks called it before COLMAP had it
  const auto* found = std::find_if(std::begin(models), std::end(models),
                                   [&](const ColmapModel& model) { return model.name == name; });
  return found == std::end(models) ? nullptr : found;
}

double* coefficient_of(Distortion& distortion, const ColmapModel& model, std::string_view name) {
  for (Tokens words(model.coefficients); !words.at_end();)
    if (const Coefficient one = next_coefficient(words); one.name == name)
      return slot_of(distortion, one.slot);
  return nullptr;
}

void set_intrinsics(Camera& camera, const ColmapModel& model, std::span<const double> parameters,
                    const Source& source, std::uint64_t offset) {
  camera.lens.model = model.lens;
  if (traits_of(model.lens).shows_sphere) return show_sphere(camera, parameters[0], parameters[1]);
  camera.fx = parameters[0], camera.fy = parameters[model.focal_lengths - 1];
  camera.cx = parameters[model.focal_lengths], camera.cy = parameters[model.focal_lengths + 1];
  const auto numbers = parameters.subspan(std::size_t(model.focal_lengths) + 2);
  std::size_t at = 0;
  for (Tokens words(model.coefficients); !words.at_end(); ++at) {
    const auto [name, slot] = next_coefficient(words);
    if (double* const coefficient = slot_of(camera.lens.distortion, slot))
      *coefficient = numbers[at];
    else if (numbers[at] != 0 && !set_special_case(camera, model, numbers))
      refuse_model(source, offset, std::string(model.name) + " with " + named_coefficient(name, numbers[at]));
  }
  const Distortion& all = camera.lens.distortion;
  Distortion radial;
  std::copy(std::begin(all.radial), std::end(all.radial), radial.radial);
  if (model.moves_twice && radial != Distortion() && radial != all)
    refuse_model(source, offset,
                 std::string(model.name) + " with radial terms beside tangential or prism ones");
}

void refuse_model(const Source& source, std::uint64_t offset, std::string_view found, std::string_view more) {
  std::string expected = "one of the camera models ";
  for (const ColmapModel& model : models)
    if (is_always_read(model)) expected.append(expected.ends_with(' ') ? "" : ", ").append(model.name);
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
