// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "gltf_nodes.hpp"
#include "gltf_primitive.hpp"
#include "scene_building.hpp"
#include "scene_readers.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

/// Gaussians of a primitive at one place.
struct Instance {
  const GltfPrimitive* gaussians;
  const GltfPlacement* place;
};

/// How many bytes instances may read for each byte of the file, so that a small file cannot fill the memory.
/// A Gaussian has at least 12 bytes of its own, its mean, and takes up to 236 in a scene: a file's Gaussians
/// take at most 315 times its bytes, and those of SPZ inside 16 times what they take alone. JSON takes up to
/// 80 times its bytes, data URIs aside.
constexpr std::uint64_t most_instances = 16;

/// The share of base64 in the work on a file that has it.
constexpr double decoding = 0.3;

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
  known.insert({"KHR_gaussian_splatting", "KHR_mesh_quantization"});
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
    std::vector<Scene> parts;
    const ProgressMeter rest = progress_.step(buffers_.has_decoded() ? decoding : 0, 1);
    const auto count = double(instances_.size());
    for (const Instance& instance : instances_) {
      const auto done = double(parts.size());
      parts.push_back(part(instance, rest.step(done / count, (done + 1) / count)));
    }
    join(std::move(parts));
    file_.format = std::string("glTF (") + (document_.binary() ? "binary" : "text") +
                   (spz_format_.empty() ? ")" : ", " + spz_format_ + " inside)");
    finish();
    return std::move(file_);
  }

 private:
  void find_instances(const JsonEntry& root) {
    placements_ = place_meshes(document_, file_.notes);
    std::size_t others = 0;
    std::uint64_t read = 0;
    for (const GltfPlacement& place : placements_) {
      const JsonEntry node = document_.item("nodes", place.node, root);
      const JsonEntry mesh = document_.item("meshes", place.mesh, node);
      if (!meshes_.contains(place.mesh)) {
        std::vector<GltfPrimitive>& found = meshes_[place.mesh];
        const json& primitives = mesh.member("primitives");
        if (!primitives.is_array()) mesh.fail("'primitives' to be an array");
        for (const json& primitive : primitives) {
          auto gaussians = find_gaussians(document_, buffers_, mesh, primitive, file_.notes);
          if (gaussians)
            found.push_back(std::move(*gaussians));
          else
            ++others;
        }
      }
      for (const GltfPrimitive& gaussians : meshes_[place.mesh]) {
        read += gaussians.span();
        instances_.push_back({&gaussians, &place});
        if (read > most_instances * buffers_.size())
          node.fail("Gaussians whose instances read their " + std::to_string(buffers_.size()) +
                    " bytes at most " + std::to_string(most_instances) + " times");
      }
    }
    if (instances_.empty()) root.fail("a glTF with Gaussians (KHR_gaussian_splatting) in its scene");
    if (others > 0)
      file_.notes.push_back("Primitives without Gaussians were left out: " + std::to_string(others) + ".");
    if (document_.size("animations") > 0) file_.notes.push_back("Animations were left out.");
  }

  Scene part(const Instance& instance, const ProgressMeter& progress) {
    const Similarity movement = movement_of(document_, *instance.place);
    Scene scene = instance.gaussians->spz_view ? read_nested(*instance.gaussians, progress)
                                               : read_accessors(*instance.gaussians, progress);
    if (movement.rotation == dmat3(1.0) && movement.scale == 1 && movement.translation == dvec3(0.0))
      return scene;
    // The Gaussians have been turned to the scene's axes, so the movement is, too.
    const AxisFlip flip = axes();
    const dvec3 signs(flip.x, flip.y, flip.z);
    Similarity turned = movement;
    turned.translation = signs * movement.translation;
    for (int column = 0; column < 3; ++column)
      turned.rotation[column] = signs[column] * (signs * movement.rotation[column]);
    try {
      transform(scene, turned);
    } catch (const std::range_error&) {
      document_.item("nodes", instance.place->node, document_.root())
          .fail("a node that keeps Gaussians within the range of float");
    }
    return scene;
  }

  AxisFlip axes() const { return early_ ? AxisFlip{} : luf_to_rdf; }

  Scene read_accessors(const GltfPrimitive& gaussians, const ProgressMeter& progress) {
    bool logarithmic = early_;
    Scene scene = decode(gaussians, axes(), progress, logarithmic);
    file_.stored += scene.size();
    if (early_)
      file_.notes.push_back(
          "An early splat-transform wrote the file: scales are logarithms, and axes are those "
          "of a PLY.");
    else if (logarithmic)
      file_.notes.push_back(
          "Some scales are below 0, so all were read as logarithms, after a draft of the "
          "extension.");
    return scene;
  }

  Scene read_nested(const GltfPrimitive& gaussians, const ProgressMeter& progress) {
    SceneReadOptions options;
    options.spz_frame = options_.spz_frame == SpzFrame::specified ? SpzFrame::luf : options_.spz_frame;
    options.progress = [&](double done) { return progress.report(done), true; };
    const std::string view = std::to_string(*gaussians.spz_view);
    SceneFile nested = read_spz({gaussians.spz, document_.source().name + ": buffer view " + view}, options);
    file_.stored += nested.stored;
    file_.dropped_nonfinite += nested.dropped_nonfinite;
    file_.notes.insert(file_.notes.end(), nested.notes.begin(), nested.notes.end());
    spz_format_ = nested.format;
    return std::move(nested.scene);
  }

  /// Puts the parts behind one another, and frees each array that was copied.
  void join(std::vector<Scene> parts) {
    Scene& all = file_.scene;
    if (parts.size() == 1) {
      all = std::move(parts.front());
      return;
    }
    std::size_t count = 0, antialiased = 0;
    for (const Scene& part : parts) {
      count += part.size(), antialiased += part.antialiased;
      all.sh_degree = std::max(all.sh_degree, part.sh_degree);
    }
    all.antialiased = antialiased == parts.size();
    if (antialiased != 0 && !all.antialiased)
      file_.notes.push_back(
          "Some Gaussians were trained with antialiasing and others were not; it is not kept.");
    // Harmonics first, as the counts of the parts are those of their means.
    const std::size_t rest = 3 * std::size_t(sh_rest_count(all.sh_degree));
    all.sh_rest.reserve(count * rest);
    for (Scene& part : parts) {
      const std::size_t stored = 3 * std::size_t(sh_rest_count(part.sh_degree));
      for (std::size_t i = 0; i < part.size(); ++i) {
        const float* from = part.sh_rest.data() + i * stored;
        all.sh_rest.insert(all.sh_rest.end(), from, from + stored);
        all.sh_rest.resize(all.sh_rest.size() + rest - stored);
      }
      part.sh_rest = {};
    }
    const auto append = [&](auto member) {
      (all.*member).reserve(count);
      for (Scene& part : parts) {
        (all.*member).insert((all.*member).end(), (part.*member).begin(), (part.*member).end());
        part.*member = {};
      }
    };
    append(&Scene::means), append(&Scene::scales), append(&Scene::rotations);
    append(&Scene::opacities), append(&Scene::sh0);
  }

  void finish() {
    file_.dropped_nonfinite += drop_nonfinite(file_.scene);
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
  std::vector<Instance> instances_{};
  std::string spz_format_{};
  SceneFile file_{};
};

}  // namespace

SceneFile read_gltf(const Source& source, const SceneReadOptions& options) {
  return GltfReader(source, options).read();
}

}  // namespace swiftgs::io
