// SPDX-License-Identifier: Apache-2.0
#include "gltf_primitive.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "formats/spz/spz_content.hpp"
#include "scene_building.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

const std::string khr_prefix = "KHR_gaussian_splatting:";

/// The object `key` of `object`; an empty one if it is absent.
const json& object_in(const JsonEntry& mesh, const json& object, const char* key) {
  static const json empty = json::object();
  const auto found = object.find(key);
  if (found == object.end()) return empty;
  if (!found->is_object()) mesh.fail(std::string("'") + key + "' of a primitive to be an object");
  return *found;
}

std::string sh_name(int degree, int coefficient) {
  return khr_prefix + "SH_DEGREE_" + std::to_string(degree) + "_COEF_" + std::to_string(coefficient);
}

/// The attributes of one primitive.
struct Attributes {
  const GltfDocument& document;
  GltfBuffers& buffers;
  const JsonEntry& mesh;
  const json& values;
  std::uint64_t count = 0;  ///< of Gaussians, once one accessor was found

  GltfAccessor find(const std::string& name, int components) {
    const auto found = values.find(name);
    if (found == values.end()) mesh.fail("Gaussians with the attribute '" + name + "'");
    if (!found->is_number_unsigned()) mesh.fail("'" + name + "' to be an index");
    const auto accessor =
        find_accessor(document, buffers, found->get<std::uint64_t>(), mesh, "'" + name + "'", components);
    if (count == 0) count = accessor.count;
    if (accessor.count != count)
      document.source().fail(accessor.offset, "'" + name + "' of " + std::to_string(count) +
                                                  " Gaussians, as 'POSITION' has, found " +
                                                  std::to_string(accessor.count));
    return accessor;
  }
};

/// Tells of attributes that are not read. Beside SPZ, attributes only say what it holds.
void note_attributes(const json& values, bool beside_spz, std::vector<std::string>& notes) {
  for (const auto& [name, value] : values.items()) {
    // COLOR_0 is what sh0 and the opacity say, for programs that draw points.
    bool read = name == "POSITION" || name == "COLOR_0" || name == khr_prefix + "ROTATION" ||
                name == khr_prefix + "SCALE" || name == khr_prefix + "OPACITY";
    if (beside_spz) read = read || name == "_ROTATION" || name == "_SCALE";
    const std::string band = khr_prefix + "SH_DEGREE_";
    for (int degree = 0; degree <= max_sh_degree; ++degree)
      read = read || name.starts_with(band + std::to_string(degree) + "_");
    if (read) continue;
    if (name.starts_with(band))
      notes.push_back("SH coefficients above degree 3 are stored; degree 3 and below are kept.");
    else
      notes.push_back("The attribute " + shown(name) + " is stored and not kept.");
  }
}

/// A value of the extension that a scene can be drawn by.
struct KnownValue {
  const char* key;
  const char* value;
  void (*apply)(RenderingModel&);
};

constexpr auto change_nothing = [](RenderingModel&) {};
constexpr auto order_by_distance = [](RenderingModel& model) { model.order = SplatOrder::distance; };
constexpr auto blend_linear = [](RenderingModel& model) { model.colours = ColourSpace::linear; };

/// The first value of a key is its default. Names of drafts follow those of the ratified text.
constexpr KnownValue known_values[] = {
    {"kernel", "ellipse", change_nothing},
    {"colorSpace", "srgb_rec709_display", change_nothing},
    {"colorSpace", "lin_rec709_display", blend_linear},
    {"colorSpace", "BT.709", change_nothing},
    {"colorSpace", "BT.709-sRGB", change_nothing},
    {"colorSpace", "BT.709-srgb", change_nothing},
    {"colorSpace", "sRGB", change_nothing},
    {"colorSpace", "BT.709-linear", blend_linear},
    {"colorSpace", "linear", blend_linear},
    {"projection", "perspective", change_nothing},
    {"sortingMethod", "cameraDistance", order_by_distance},
    {"sortingMethod", "zDepth", change_nothing},
};

/// Takes a value of `extension`, or of the `hints` that drafts had in its place.
void take_value(const JsonEntry& mesh, const json& extension, const std::string& key, RenderingModel& model) {
  const json& hints = object_in(mesh, extension, "hints");
  const json& owner = extension.contains(key) ? extension : hints;
  const auto found = owner.find(key);
  if (found != owner.end() && !found->is_string()) mesh.fail("'" + key + "' to be a string");
  const std::string value = found == owner.end() ? "" : found->get<std::string>();
  std::string names;
  for (const KnownValue& known : known_values) {
    if (key != known.key) continue;
    if (value.empty() || value == known.value) return known.apply(model);
    names += (names.empty() ? "" : ", ") + std::string(known.value);
  }
  mesh.fail("the " + key + " of Gaussians to be one of " + names + ", found " + shown(json(value)));
}

/// How the Gaussians were trained to be drawn. Throws `FormatError` where no frame can follow it.
RenderingModel model_of(const JsonEntry& mesh, const json& extension) {
  RenderingModel model;
  for (const char* key : {"kernel", "colorSpace", "projection", "sortingMethod"})
    take_value(mesh, extension, key, model);
  return model;
}

void expect_points(const JsonEntry& mesh, const json& primitive) {
  const auto mode = primitive.find("mode");
  if (mode == primitive.end() || *mode != 0) mesh.fail("Gaussians in a primitive of points ('mode': 0)");
  if (primitive.contains("indices")) mesh.fail("Gaussians without 'indices', which are not supported");
}

GltfPrimitive find_accessors(Attributes attributes) {
  const json& values = attributes.values;
  GltfPrimitive gaussians;
  gaussians.mean = attributes.find("POSITION", 3);
  gaussians.count = attributes.count;
  gaussians.rotation = attributes.find(khr_prefix + "ROTATION", 4);
  gaussians.scale = attributes.find(khr_prefix + "SCALE", 3);
  gaussians.opacity = attributes.find(khr_prefix + "OPACITY", 1);
  if (gaussians.opacity.type != GltfAccessor::f32 && !gaussians.opacity.normalised)
    attributes.document.source().fail(gaussians.opacity.offset, "opacities of integers to be 'normalized'");
  gaussians.sh0 = attributes.find(sh_name(0, 0), 3);
  // A band with one coefficient must have all, and so must those below.
  for (int degree = 1; degree <= max_sh_degree; ++degree)
    for (int k = 0; k <= 2 * degree; ++k)
      if (values.contains(sh_name(degree, k))) gaussians.sh_degree = degree;
  for (int degree = 1; degree <= gaussians.sh_degree; ++degree)
    for (int k = 0; k <= 2 * degree; ++k) gaussians.sh_rest.push_back(attributes.find(sh_name(degree, k), 3));
  return gaussians;
}

/// Decodes Gaussians [begin, end) of `from`. Gaussian i becomes number i + `shift` of the scene.
void decode_block(const GltfPrimitive& from, const AxisFlip& flip, bool logarithmic, std::size_t begin,
                  std::size_t end, std::size_t shift, Scene& scene) {
  for_vectors<3>(from.mean, begin, end, [&](std::size_t i, const float* v) {
    scene.means[i + shift] = flip.position({v[0], v[1], v[2]});
  });
  for_vectors<4>(from.rotation, begin, end, [&](std::size_t i, const float* v) {
    scene.rotations[i + shift] = flip.rotation(rotation_of(v[3], v[0], v[1], v[2]));
  });
  for_vectors<3>(from.scale, begin, end, [&](std::size_t i, const float* v) {
    for (int axis = 0; axis < 3; ++axis)
      scene.scales[i + shift][axis] = logarithmic ? std::exp(v[axis]) : v[axis];
  });
  for_vectors<1>(from.opacity, begin, end,
                 [&](std::size_t i, const float* v) { scene.opacities[i + shift] = v[0]; });
  for_vectors<3>(from.sh0, begin, end, [&](std::size_t i, const float* v) {
    scene.sh0[i + shift] = {v[0], v[1], v[2]};
  });
  const auto signs = flip.sh_signs();
  const std::size_t stride = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t k = 0; k < from.sh_rest.size(); ++k)
    for_vectors<3>(from.sh_rest[k], begin, end, [&](std::size_t i, const float* v) {
      float* to = &scene.sh_rest[(i + shift) * stride + 3 * k];
      for (int c = 0; c < 3; ++c) to[c] = signs[k] * v[c];
    });
}

}  // namespace

std::optional<GltfPrimitive> find_gaussians(const GltfDocument& document, GltfBuffers& buffers,
                                            const JsonEntry& mesh, const json& primitive,
                                            std::vector<std::string>& notes) {
  if (!primitive.is_object()) mesh.fail("primitives that are objects");
  const json& extensions = object_in(mesh, primitive, "extensions");
  const json& own = object_in(mesh, extensions, "KHR_gaussian_splatting");
  const json& nested = object_in(mesh, own, "extensions");
  const json& values = object_in(mesh, primitive, "attributes");
  for (const char* name : gltf_spz_extensions)
    for (const json* place : {&nested, &extensions}) {
      if (!place->contains(name)) continue;
      expect_points(mesh, primitive);
      note_attributes(values, true, notes);
      const json& compressed = object_in(mesh, *place, name);
      const auto view = compressed.find("bufferView");
      if (view == compressed.end() || !view->is_number_unsigned())
        mesh.fail(std::string("'") + name + "' with the index 'bufferView'");
      GltfPrimitive gaussians{.model = model_of(mesh, own), .spz_view = view->get<std::uint64_t>()};
      gaussians.spz = buffers.view(*gaussians.spz_view, mesh).bytes;
      const SpzHeader header = read_spz_header(gaussians.spz_source(document.source()));
      gaussians.count = header.count, gaussians.sh_degree = std::min(header.sh_degree, max_sh_degree);
      gaussians.model.antialiased = header.antialiased;
      return gaussians;
    }
  if (!extensions.contains("KHR_gaussian_splatting")) return std::nullopt;
  expect_points(mesh, primitive);
  note_attributes(values, false, notes);
  GltfPrimitive gaussians = find_accessors({document, buffers, mesh, values});
  gaussians.model = model_of(mesh, own);
  return gaussians;
}

bool has_scale_below_zero(const GltfPrimitive& primitive, const ProgressMeter& progress) {
  std::atomic<bool> found = false;
  for_parts(primitive.scale.count, progress, [&](std::size_t begin, std::size_t end) {
    bool below = false;
    for_vectors<3>(primitive.scale, begin, end,
                   [&](std::size_t, const float* v) { below |= v[0] < 0 || v[1] < 0 || v[2] < 0; });
    if (below) found = true;
  });
  return found;
}

void decode(const GltfPrimitive& primitive, const AxisFlip& flip, bool logarithmic, const GltfRange& range,
            const ProgressMeter& progress, Scene& scene) {
  const std::size_t shift = range.to - range.first;  // modulo 2^64, as all of this arithmetic is
  for_parts(range.count, progress, [&](std::size_t begin, std::size_t end) {
    // Attributes lie apart, and what a block of them fills stays in the cache.
    constexpr std::size_t block = 128;
    for (std::size_t first = begin; first < end; first += block)
      decode_block(primitive, flip, logarithmic, range.first + first,
                   range.first + std::min(end, first + block), shift, scene);
  });
}

}  // namespace swiftgs::io
