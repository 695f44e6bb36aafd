// SPDX-License-Identifier: Apache-2.0

#include "camera_parsing.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <string>

#include <glm/matrix.hpp>

#include <swiftgs/error.hpp>

#include "colmap_models.hpp"
#include "text.hpp"

namespace swiftgs::io {

void set_pose(Camera& camera, const dmat3& axes, dvec3 centre) {
  camera.rotation = glm::transpose(axes);
  camera.translation = dvec3(0.0);
  for (int column = 0; column < 3; ++column) camera.translation -= camera.rotation[column] * centre[column];
}

void set_opengl_pose(Camera& camera, const dmat3& axes, dvec3 centre) {
  set_pose(camera, dmat3(axes[0], -axes[1], -axes[2]), centre);
}

void show_sphere(Camera& camera, double width, double height) {
  camera.fx = width / (2 * std::numbers::pi), camera.fy = height / std::numbers::pi;
  camera.cx = 0.5 * width, camera.cy = 0.5 * height;
}

int to_side(const Source& source, std::uint64_t offset, double pixels) {
  if (!(pixels >= 1 && pixels <= max_image_side) || pixels != std::floor(pixels))
    source.fail(offset, "a width and a height of 1 to " + std::to_string(max_image_side) + " pixels");
  return int(pixels);
}

void expect_valid(const Source& source, std::uint64_t offset, const Camera& camera) {
  try {
    validate(camera);
  } catch (const InvalidArgument& error) {
    source.fail(offset, std::string("a camera that can be rendered with (") + error.what() + ")");
  }
}

namespace {

using nlohmann::json;

/// Of COLMAP's models, by its names. EUCM's `beta` does nothing where `alpha` is 0.
constexpr const char* coefficients[] = {"k",  "k1", "k2",  "k3",  "k4",    "k5",   "k6",
                                        "p1", "p2", "sx1", "sy1", "omega", "alpha"};

/// What nerfstudio's list of coefficients holds; it counts before keys of their own.
constexpr const char* list = "distortion_params";
constexpr std::string_view listed_coefficients[] = {"k1", "k2", "k3", "k4", "p1", "p2"};

/// How instant-ngp marks its lenses that are read.
struct Mark {
  const char* key;
  LensModel lens;
};
constexpr Mark marks[] = {{"is_fisheye", LensModel::fisheye}, {"latlong", LensModel::equirectangular}};

/// How it marks others, and cameras whose own axes are Mitsuba's. Its `equirectangular` has rows of equal
/// area, and focal lengths of its `orthographic` are of a scene that it has scaled.
constexpr const char* refused[] = {"ftheta_p0", "equirectangular", "orthographic", "from_mitsuba",
                                   "normal_mts_args"};

constexpr std::string_view more_models = ", ORTHOPHOTO";

/// Whether a value says nothing: 0, false, null, "", or a list of these.
bool is_off(const json& value) {
  const auto off = [](const json& one) {
    return one.is_number() ? one.get<double>() == 0 : one.is_null() || one == json(false) || one == json("");
  };
  return value.is_structured() ? std::all_of(value.begin(), value.end(), off) : off(value);
}

/// The lens of the model that COLMAP or nerfstudio calls `name`; null if none is read. Of a model that moves
/// points twice, nobody knows by which keys a file would say so.
std::optional<LensModel> lens_called(std::string_view name) {
  if (name == "ORTHOPHOTO") return LensModel::orthographic;
  const ColmapModel* const model = colmap_model(name);
  return model && !model->moves_twice ? std::optional(model->lens) : std::nullopt;
}

/// The coefficient of one object; null if it has none.
std::optional<double> coefficient_in(const JsonEntry& entry, const char* key) {
  const auto* const at = std::ranges::find(listed_coefficients, std::string_view(key));
  if (entry.has(list) && at != std::end(listed_coefficients)) {
    const json& values = entry.member(list);
    if (is_off(values)) return 0.0;
    if (!values.is_array() || values.size() != std::size(listed_coefficients))
      entry.fail("the six numbers k1, k2, k3, k4, p1 and p2 in 'distortion_params'");
    return entry.number(list, std::size_t(at - listed_coefficients));
  }
  if (!entry.has(key)) return {};
  return is_off(entry.member(key)) ? 0.0 : entry.number(key);
}

/// The coefficient `key` of a camera of the COLMAP model `model`, which may be unknown. Some programs write
/// coefficients that the model lacks: these are taken as those of THIN_PRISM_FISHEYE. Null if that model
/// lacks the coefficient too.
double* coefficient_of(Distortion& distortion, std::string_view key, std::string_view model) {
  const ColmapModel* const known = colmap_model(model);
  double* const own = known ? coefficient_of(distortion, *known, key) : nullptr;
  return own ? own : coefficient_of(distortion, *colmap_model("THIN_PRISM_FISHEYE"), key);
}

}  // namespace

Lens lens_of(const CameraEntry& entry) {
  for (const char* key : refused)
    if (const JsonEntry* with = entry.with(key); with && !is_off(with->member(key)))
      refuse_model(with->source(), with->offset(), std::string("'") + key + "'", more_models);
  Lens lens;
  std::string name;
  if (const JsonEntry* with = entry.with("camera_model")) {
    name = with->string("camera_model");
    const std::optional<LensModel> called = lens_called(name);
    if (!called) refuse_model(with->source(), with->offset(), listed({name}), more_models);
    lens.model = *called;
  }
  for (const auto& [key, model] : marks)
    if (const JsonEntry* with = entry.with(key); with && !is_off(with->member(key))) {
      if (!name.empty() && lens.model != model)
        with->fail(std::string("one lens, found '") + key + "' and the camera model " + listed({name}));
      lens.model = model;
    }
  const std::string owner = name.empty() ? "" : name + " with ";
  const auto refuse = [&](const JsonEntry& one, const char* key, const json& value) {
    refuse_model(one.source(), one.offset(), owner + named_coefficient(key, value), more_models);
  };
  // nerfstudio's list has its own k4, and it reads no FULL_OPENCV.
  if (const JsonEntry* with = entry.with(list); with && name == "FULL_OPENCV" && !is_off(with->member(list)))
    refuse(*with, list, with->member(list));
  for (const char* key : coefficients)
    for (const JsonEntry* one : {&entry.own, &entry.shared}) {
      const std::optional<double> value = coefficient_in(*one, key);
      if (!value) continue;
      double* const slot =
          traits_of(lens.model).takes_distortion ? coefficient_of(lens.distortion, key, name) : nullptr;
      if (*value != 0 && !slot) refuse(*one, key, *value);
      if (*value != 0) *slot = *value;
      break;
    }
  return lens;
}

double length_of_angle(const JsonEntry& entry, const char* key, double to_radians, int side) {
  const double radians = to_radians * entry.number(key);
  if (!(radians > 0 && radians < std::numbers::pi))
    entry.fail(std::string("an angle above 0 and below pi (180 degrees) in '") + key + "'");
  return 0.5 * side / std::tan(0.5 * radians);
}

void UnreadKeys::add(const JsonEntry& entry) {
  const auto is_in = [](const auto& keys, const std::string& key) {
    return std::find(std::begin(keys), std::end(keys), key) != std::end(keys);
  };
  const auto is_mark = [](const std::string& key) {
    return std::ranges::any_of(marks, [&](const Mark& mark) { return mark.key == key; });
  };
  for (const auto& [key, value] : entry.members().items())
    if (!is_in(read_, key) && !is_in(coefficients, key) && !is_in(refused, key) && !is_mark(key) &&
        key != list && key != "camera_model" && !is_off(value))
      keys_.insert(key);
}

void UnreadKeys::note(std::vector<std::string>& notes) const {
  if (!keys_.empty())
    notes.push_back(
        "Keys that may change the picture were not read: " + listed({keys_.begin(), keys_.end()}) + ".");
}

}  // namespace swiftgs::io
