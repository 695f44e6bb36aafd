// SPDX-License-Identifier: Apache-2.0
#include "camera_entry.hpp"

#include <algorithm>
#include <iterator>

#include "colmap_models.hpp"
#include "listed.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

/// Of COLMAP's models, by its names, and of nerfstudio's `distortion_params`. EUCM's `beta` does nothing
/// where `alpha` is 0.
constexpr const char* coefficients[] = {"k",  "k1", "k2", "k3",    "k4",    "k5",
                                        "k6", "p1", "p2", "omega", "alpha", "distortion_params"};

/// How instant-ngp marks its other lenses, and cameras whose own axes are Mitsuba's.
constexpr const char* lenses[] = {"is_fisheye",   "ftheta_p0",    "latlong",        "equirectangular",
                                  "orthographic", "from_mitsuba", "normal_mts_args"};

/// Whether a value says nothing: 0, false, null, "", or a list of these.
bool is_off(const json& value) {
  const auto off = [](const json& one) {
    return one.is_number() ? one.get<double>() == 0 : one.is_null() || one == json(false) || one == json("");
  };
  return value.is_structured() ? std::all_of(value.begin(), value.end(), off) : off(value);
}

}  // namespace

void expect_pinhole(const CameraEntry& entry) {
  if (const JsonEntry* with = entry.with("camera_model")) {
    const std::string name = with->string("camera_model");
    const ColmapModel* model = colmap_model(name);
    if (!model || model->zeros == ColmapModel::never) refuse_model(with->source(), with->offset(), name);
  }
  for (const char* key : coefficients)
    if (const JsonEntry* with = entry.with(key); with && !is_off(with->member(key)))
      refuse_model(with->source(), with->offset(), coefficient(key, with->member(key)));
  for (const char* key : lenses)
    if (const JsonEntry* with = entry.with(key); with && !is_off(with->member(key)))
      refuse_model(with->source(), with->offset(), std::string("'") + key + "'");
}

void UnreadKeys::add(const JsonEntry& entry) {
  const auto is_in = [](const auto& keys, const std::string& key) {
    return std::find(std::begin(keys), std::end(keys), key) != std::end(keys);
  };
  for (const auto& [key, value] : entry.members().items())
    if (!is_in(read_, key) && !is_in(coefficients, key) && !is_in(lenses, key) && key != "camera_model" &&
        !is_off(value))
      keys_.insert(key);
}

void UnreadKeys::note(std::vector<std::string>& notes) const {
  if (!keys_.empty())
    notes.push_back(
        "Keys that may change the picture were not read: " + listed({keys_.begin(), keys_.end()}) + ".");
}

}  // namespace swiftgs::io
