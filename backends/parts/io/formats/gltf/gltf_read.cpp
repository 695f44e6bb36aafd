// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include <swiftgs/edit/transform.hpp>

#include "gltf_document.hpp"
#include "gltf_primitive.hpp"
#include "scene_building.hpp"
#include "scene_format.hpp"
#include "text.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

/// Gaussians of a primitive at one place.
struct Instance {
  const GltfPrimitive* gaussians;
  const GltfPlacement* place;
};

/// A small file cannot fill the memory by accessors that share bytes, or by many instances of a mesh: its
/// Gaussians, each counted as often as a node places it, are at most so many for each byte of its buffers.
constexpr std::uint64_t max_gltf_gaussians_per_byte = 8;

/// The share of base64 in the work on a file that has it.
constexpr double decoding = 0.3;

/// Part of the remaining progress that the search for logarithmic scales takes.
constexpr double measuring = 0.05;

/// Gaussians that are moved at a time: few, since each block is a copy.
constexpr std::size_t moved_at_once = 1 << 18;

std::vector<std::string> strings(const JsonEntry& root, const char* key) {
  std::vector<std::string> result;
  if (!root.has(key)) return result;
  const json& values = root.member(key);
  if (!values.is_array()) root.fail(std::string("'") + key + "' to be an array");
  for (const json& value : values) {
    if (!value.is_string()) root.fail(std::string("strings in '") + key + "'");
    result.push_back(value.get<std::string>());
  }
  return result;
}

void check_extensions(const JsonEntry& root, std::vector<std::string>& notes) {
  std::set<std::string> known(std::begin(gltf_spz_extensions), std::end(gltf_spz_extensions));
  known.insert({"KHR_gaussian_splatting", "KHR_mesh_quantization", gltf_visibility_extension});
  for (const std::string& name : strings(root, "extensionsRequired"))
    if (!known.contains(name))
      root.fail("no required extension beside those of Gaussians, found " + shown(name));
  for (const std::string& name : strings(root, "extensionsUsed"))
    if (!known.contains(name)) notes.push_back("The extension " + shown(name) + " is used and not read.");
}

/// Whether the file is of a version of splat-transform before 2. It wrote logarithms of scales, as drafts of
/// the extension had them, and the axes of PLY files instead of glTF's. Later versions, and other programs
/// that followed a draft, turned the axes, so only this program's name tells.
bool is_early_splat_transform(const JsonEntry& root) {
  if (!root.has("asset")) return false;
  const json& asset = root.member("asset");
  if (!asset.is_object() || !asset.contains("generator")) return false;
  const json& generator = asset["generator"];
  if (!generator.is_string()) return false;
  const auto& name = generator.get_ref<const std::string&>();
  return name.starts_with("splat-transform 0.") || name.starts_with("splat-transform 1.");
}

class GltfReader {
 public:
  GltfReader(const Source& source, const SceneReadOptions& options)
      : options_(options),
        progress_(options.progress, source.name),
        document_(source),
        buffers_(document_, progress_.step(0, decoding)) {}

  SceneFile read() {
    const JsonEntry root = document_.root();
    check_extensions(root, file_.notes);
    early_ = is_early_splat_transform(root);
    find_instances(root);
    const ProgressMeter rest = progress_.step(buffers_.has_decoded() ? decoding : 0, 1);
    find_logarithms(rest.step(0, measuring));
    fill(rest.step(measuring, 1));
    file_.format = std::string("glTF (") + (document_.binary() ? "binary" : "text") +
                   (spz_format_.empty() ? ")" : ", " + spz_format_ + " inside)");
    finish();
    return std::move(file_);
  }

 private:
  /// The Gaussians of a mesh that `node` places, found once.
  const std::vector<GltfPrimitive>& gaussians_of(std::uint64_t index, const JsonEntry& node) {
    const JsonEntry mesh = document_.item("meshes", index, node);
    const auto [entry, is_new] = meshes_.try_emplace(index);
    if (!is_new) return entry->second;
    const json& primitives = mesh.member("primitives");
    if (!primitives.is_array()) mesh.fail("'primitives' to be an array");
    for (const json& primitive : primitives) {
      auto gaussians = find_gaussians(document_, buffers_, mesh, primitive, file_.notes);
      if (!gaussians) {
        ++others_;
        continue;
      }
      entry->second.push_back(std::move(*gaussians));
      if (primitive.contains("targets")) file_.notes.push_back("Morph targets were left out.");
    }
    return entry->second;
  }

  void add_instances(const GltfPlacement& place, const std::vector<GltfPrimitive>& all,
                     const JsonEntry& node) {
    expect_drawable(document_, place);
    for (const GltfPrimitive& gaussians : all) {
      instances_.push_back({&gaussians, &place});
      count_ += gaussians.count;
      if (count_ / max_gltf_gaussians_per_byte > buffers_.size())
        node.fail("at most " + std::to_string(max_gltf_gaussians_per_byte) +
                  " Gaussians, those of each instance counted, for each of the " +
                  std::to_string(buffers_.size()) + " bytes of the buffers, found " + std::to_string(count_));
    }
  }

  void find_instances(const JsonEntry& root) {
    placements_ = place_meshes(document_, file_.notes);
    std::size_t hidden = 0, skinned = 0;
    for (const GltfPlacement& place : placements_) {
      const JsonEntry node = document_.item("nodes", place.node, root);
      const std::vector<GltfPrimitive>& all = gaussians_of(place.mesh, node);
      if (all.empty()) continue;
      if (place.is_hidden()) {
        for (const GltfPrimitive& gaussians : all) hidden += gaussians.count;
        continue;
      }
      add_instances(place, all, node);
      skinned += node.has("skin");
    }
    if (instances_.empty())
      root.fail(std::string("a glTF with Gaussians (KHR_gaussian_splatting) in its scene") +
                (hidden > 0 ? ", found only those of hidden nodes" : ""));
    if (hidden > 0)
      file_.notes.push_back("Gaussians of hidden nodes were left out: " + std::to_string(hidden) + ".");
    if (others_ > 0)
      file_.notes.push_back("Primitives without Gaussians were left out: " + std::to_string(others_) + ".");
    if (document_.size("animations") > 0) file_.notes.push_back("Animations were left out.");
    if (skinned > 0) file_.notes.push_back("Skins were left out: Gaussians are where their nodes are.");
  }

  /// Decides for all accessors of the file whether scales are logarithms.
  void find_logarithms(const ProgressMeter& progress) {
    logarithmic_ = early_;
    double done = 0;
    for (const auto& [mesh, primitives] : meshes_)
      for (const GltfPrimitive& gaussians : primitives) {
        const double part = 1 / double(instances_.size());
        const ProgressMeter step = progress.step(done, std::min(done + part, 1.0));
        done = std::min(done + part, 1.0);
        if (gaussians.spz_view || logarithmic_) continue;
        logarithmic_ = has_scale_below_zero(gaussians, step);
      }
    if (early_)
      file_.notes.push_back(
          "An early splat-transform wrote the file: scales are logarithms, and axes are those "
          "of a PLY.");
    else if (logarithmic_)
      file_.notes.push_back(
          "Some scales are below 0, so all were read as logarithms, after a draft of the "
          "extension.");
  }

  /// Takes the memory of all Gaussians and decodes each instance to its place.
  void fill(const ProgressMeter& progress) {
    Scene& scene = file_.scene;
    if (instances_.size() == 1 && instances_.front().gaussians->spz_view) {
      scene = read_nested(instances_.front(), progress);
      scene.model = instances_.front().gaussians->model;
      return;
    }
    int sh_degree = 0;
    for (const Instance& instance : instances_)
      sh_degree = std::max(sh_degree, instance.gaussians->sh_degree);
    allocate(scene, count_, sh_degree);
    std::size_t at = 0;
    for (const Instance& instance : instances_) {
      const std::size_t count = instance.gaussians->count;
      const ProgressMeter step =
          progress.step(double(at) / double(count_), double(at + count) / double(count_));
      if (instance.gaussians->spz_view) {
        const Scene part = read_nested(instance, step);
        copy(part, at);
        at += part.size();
      } else {
        at += place_accessors(instance, at, step);
      }
    }
    resize(scene, at);
    scene.model = common_model();
  }

  /// The model of the first Gaussians, unless others differ. Throws `FormatError` for colours of both kinds.
  RenderingModel common_model() {
    RenderingModel common = instances_.front().gaussians->model;
    for (const Instance& instance : instances_) {
      const RenderingModel& model = instance.gaussians->model;
      if (model.colours != common.colours)
        document_.root().fail(
            "Gaussians of one 'colorSpace', found some of sRGB-encoded and some of linear colours");
      if (model.antialiased != common.antialiased)
        file_.notes.push_back(
            "Some Gaussians were trained with antialiasing and others were not; all are drawn without.");
      if (model.order != common.order)
        file_.notes.push_back(
            "Some Gaussians were trained to be sorted by distance and others by depth; all are by distance.");
    }
    for (const Instance& instance : instances_) {
      common.antialiased = common.antialiased && instance.gaussians->model.antialiased;
      if (instance.gaussians->model.order == SplatOrder::distance) common.order = SplatOrder::distance;
    }
    return common;
  }

  AxisFlip axes() const { return early_ ? AxisFlip{} : luf_to_rdf; }

  /// Decodes the Gaussians of accessors as numbers `at` on. Returns how many: those that are moved have no
  /// fault, as a movement makes rotations of all quaternions.
  std::size_t place_accessors(const Instance& instance, std::size_t at, const ProgressMeter& progress) {
    const GltfPrimitive& gaussians = *instance.gaussians;
    file_.stored += gaussians.count;
    if (stays(instance)) {
      decode(gaussians, axes(), logarithmic_, {0, gaussians.count, at}, progress, file_.scene);
      stay(file_.scene, at, gaussians.count);
      return gaussians.count;
    }
    const Progress none;
    const ProgressMeter silent(none, "");
    std::size_t placed = 0;
    for (std::size_t first = 0; first < gaussians.count; first += moved_at_once) {
      progress.report(double(first) / double(gaussians.count));
      Scene part;
      allocate(part, std::min(moved_at_once, gaussians.count - first), gaussians.sh_degree);
      decode(gaussians, axes(), logarithmic_, {first, part.size(), 0}, silent, part);
      file_.left_out += leave_out_invalid(part);
      move(part, instance);
      copy(part, at + placed);
      placed += part.size();
    }
    progress.report(1);
    return placed;
  }

  Scene read_nested(const Instance& instance, const ProgressMeter& progress) {
    SceneReadOptions options;
    options.spz_frame = options_.spz_frame == SpzFrame::specified ? SpzFrame::luf : options_.spz_frame;
    options.progress = [&](double done) { return progress.report(done), true; };
    SceneFile nested = spz_format.read(instance.gaussians->spz_source(document_.source()), options);
    file_.stored += nested.stored;
    file_.left_out += nested.left_out;
    file_.notes.insert(file_.notes.end(), nested.notes.begin(), nested.notes.end());
    spz_format_ = nested.format;
    if (stays(instance))
      stay(nested.scene, 0, nested.scene.size());
    else
      move(nested.scene, instance);
    return std::move(nested.scene);
  }

  static bool stays(const Instance& instance) {
    const Affine& by = instance.place->movement;
    return by.linear == dmat3(1.0) && by.translation == dvec3(0.0);
  }

  /// Moves Gaussians that have been turned to the scene's axes, as the movement is here.
  void move(Scene& part, const Instance& instance) {
    const AxisFlip flip = axes();
    const dvec3 signs(flip.x, flip.y, flip.z);
    Affine turned = instance.place->movement;
    turned.translation *= signs;
    for (int column = 0; column < 3; ++column) turned.linear[column] *= signs[column] * signs;
    if (!origin_ && part.size() != 0) origin_ = origin_for(part, turned);
    try {
      stretch(part, turned, origin_.value_or(dvec3(0.0)));
    } catch (const std::range_error&) {
      document_.item("nodes", instance.place->node, document_.root())
          .fail("a node that keeps Gaussians within the range of float");
    }
  }

  /// Gaussians [begin, begin + count), which are where they belong, relative to the origin.
  void stay(Scene& scene, std::size_t begin, std::size_t count) {
    if (!origin_ && count != 0) origin_ = dvec3(0.0);
    if (!origin_ || *origin_ == dvec3(0.0)) return;
    for (vec3& mean : std::span(scene.means).subspan(begin, count)) mean = vec3(dvec3(mean) - *origin_);
  }

  static void resize(Scene& scene, std::size_t count) {
    for_each_array([&](const char*, std::size_t each, auto& values) { values.resize(each * count); }, scene);
  }

  /// Copies `part`, whose degree may be lower, to numbers `at` on.
  void copy(const Scene& part, std::size_t at) {
    const auto to = [&](auto& values) { return values.begin() + std::ptrdiff_t(at); };
    Scene& all = file_.scene;
    std::copy(part.means.begin(), part.means.end(), to(all.means));
    std::copy(part.scales.begin(), part.scales.end(), to(all.scales));
    std::copy(part.rotations.begin(), part.rotations.end(), to(all.rotations));
    std::copy(part.opacities.begin(), part.opacities.end(), to(all.opacities));
    std::copy(part.sh0.begin(), part.sh0.end(), to(all.sh0));
    const auto from = 3 * std::size_t(sh_rest_count(part.sh_degree));
    const auto stride = 3 * std::size_t(sh_rest_count(all.sh_degree));
    for (std::size_t i = 0; i < part.size(); ++i)
      std::copy_n(part.sh_rest.data() + i * from, from, all.sh_rest.data() + (at + i) * stride);
  }

  void finish() {
    file_.bytes = buffers_.size_beside();
    file_.left_out += leave_out_invalid(file_.scene);
    file_.scene.origin = origin_.value_or(dvec3(0.0));
    std::size_t clamped = 0;
    for (float& opacity : file_.scene.opacities) {
      if (opacity >= 0 && opacity <= 1) continue;
      opacity = std::clamp(opacity, 0.0f, 1.0f);
      ++clamped;
    }
    if (clamped > 0)
      file_.notes.push_back("Opacities outside [0, 1] were clamped: " + std::to_string(clamped) + ".");
    std::set<std::string> told;
    std::erase_if(file_.notes, [&](const std::string& note) { return !told.insert(note).second; });
  }

  const SceneReadOptions& options_;
  ProgressMeter progress_;
  GltfDocument document_;
  GltfBuffers buffers_;
  bool early_ = false;
  std::vector<GltfPlacement> placements_{};
  std::map<std::uint64_t, std::vector<GltfPrimitive>> meshes_{};
  std::size_t others_ = 0;  ///< primitives without Gaussians
  std::vector<Instance> instances_{};
  std::uint64_t count_ = 0;  ///< of Gaussians of all instances
  bool logarithmic_ = false;
  std::optional<dvec3> origin_{};  ///< as the first Gaussians that are placed need it, and fit the others
  std::string spz_format_{};
  SceneFile file_{};
};

bool is_binary_gltf(std::string_view text) { return text.starts_with("glTF"); }

/// Whether a file is JSON that a glTF alone has, or is called so. A SOG folder's, too, may have a member
/// "asset".
bool looks_like_gltf(std::string_view text, std::string_view name) {
  const std::string_view beginning = text.substr(json_start(text), 1 << 16);
  if (!beginning.starts_with('{')) return false;
  const auto holds = [&](std::string_view word) { return beginning.find(word) != beginning.npos; };
  return has_ending(name, ".gltf") || holds("\"KHR_gaussian_splatting") || holds("\"KHR_spz_gaussian") ||
         (holds("\"asset\"") && (holds("\"buffers\"") || holds("\"accessors\"") || holds("\"meshes\"")));
}

SceneFile read_gltf(const Source& source, const SceneReadOptions& options) {
  return GltfReader(source, options).read();
}

}  // namespace

constinit const SceneFormat gltf_format{.name = "a glTF",
                                        .names = {".glb", ".gltf"},
                                        .has_mark = is_binary_gltf,
                                        .looks_so = looks_like_gltf,
                                        .read = read_gltf,
                                        .place_in_capture = 8,
                                        .last_in_capture = true};

}  // namespace swiftgs::io
