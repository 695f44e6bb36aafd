// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include <swiftgs/camera.hpp>

#include "bytes.hpp"

namespace swiftgs::io {

/// A camera model of COLMAP. Its numbers are the focal lengths, the principal point, and coefficients; those
/// of EQUIRECTANGULAR are the width and the height of a whole sphere.
struct ColmapModel {
  std::string_view name;
  int parameters;     ///< numbers behind the size
  int focal_lengths;  ///< the first of them; none of a sphere
  LensModel lens;     ///< what maps directions to the plane
  /// Words `NAME` or `NAME:SLOT`: COLMAP's name of a coefficient and its place in `Distortion`, k1 to k4
  /// (radial), q1 to q3 (rational), p1, p2 (tangential), or s1, s2 (prism). A coefficient whose slot is empty
  /// has no place there, and its model is read where the coefficient is 0.
  std::string_view coefficients;
  /// Tangential and prism terms take the point that radial terms have moved. Such a model is read where it
  /// has one kind of terms alone.
  bool moves_twice = false;

  static constexpr int most_parameters = 16;
};

/// The model that COLMAP numbers or names so, in its newest release or in a fork; null if it has none.
const ColmapModel* colmap_model(std::int32_t id);
const ColmapModel* colmap_model(std::string_view name);

/// The coefficient that `model` calls `name`; null if `Distortion` has no place for it.
double* coefficient_of(Distortion& distortion, const ColmapModel& model, std::string_view name);

/// Sets the intrinsics and the lens of `camera`. Throws `FormatError` that names the model, and the
/// coefficient if it is that, where `Lens` cannot be the model.
void set_intrinsics(Camera& camera, const ColmapModel& model, std::span<const double> parameters,
                    const Source& source, std::uint64_t offset);

/// Throws `FormatError`: expected one of the models that are read whatever their coefficients, or `more`, and
/// names `found`.
[[noreturn]] void refuse_model(const Source& source, std::uint64_t offset, std::string_view found,
                               std::string_view more = "");

/// A coefficient that is not 0 as messages name it: `k1 = 0.1`. Of a list only the name.
std::string named_coefficient(std::string_view name, const nlohmann::json& value);

/// A pose as COLMAP writes it: world to camera, Hamilton quaternion, scalar part first, of any length.
struct ColmapPose {
  double w, x, y, z;
  dvec3 translation;
  std::uint32_t camera_id;
};

/// COLMAP's file of cameras. A camera is read when an image uses it, so that others may be of any model.
class ColmapCameras {
 public:
  /// `read` reads the camera at an offset of `source`, which must outlive this.
  ColmapCameras(const Source& source, Camera (*read)(const Source&, std::uint64_t))
      : source_(source), read_(read) {}

  /// Notes where the camera with this id is. Throws `FormatError` if another has it.
  void add(std::uint32_t id, std::uint64_t offset);

  /// The camera of one image. Throws `FormatError` at `offset` of `images` if its id is unknown or it cannot
  /// be rendered with.
  Camera place(const Source& images, std::uint64_t offset, const ColmapPose& pose,
               std::string_view name) const;

 private:
  const Source& source_;
  Camera (*read_)(const Source&, std::uint64_t);
  std::map<std::uint32_t, std::uint64_t> offsets_;
};

}  // namespace swiftgs::io
