// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include "file_kind.hpp"
#include "scene_building.hpp"
#include "scene_format.hpp"
#include "sog_content.hpp"
#include "text.hpp"

namespace swiftgs::io {

void SogFindings::add(const SogMeta& meta, std::uint64_t odd_labels) {
  (meta.model.antialiased ? antialiased_ : plain_) = true;
  if (meta.model.kernel == RenderingModel::Kernel::disk) kernel_ = meta.model.kernel;
  if (!meta.unknown_model.empty()) unknown_model_ = meta.unknown_model;
  odd_labels_ += odd_labels;
}

void SogFindings::finish(SceneFile& file) const {
  const auto note = [&](const std::string& text) { file.notes.push_back(text); };
  file.left_out = leave_out_invalid(file.scene);
  file.scene.model.antialiased = antialiased_, file.scene.model.kernel = kernel_;
  if (antialiased_ && plain_)
    note("Some parts were trained with antialiasing and some without; all are rendered with it.");
  if (!unknown_model_.empty()) note("The render model '" + unknown_model_ + "' is not known, and ignored.");
  if (odd_labels_ > 0)
    note(std::to_string(odd_labels_) +
         " Gaussians name an entry that the palette of harmonics lacks; theirs are 0.");
}

bool has_sog_keys(std::string_view text, std::string_view name, std::string_view first,
                  std::string_view second) {
  return text.substr(json_start(text)).starts_with('{') && text.find(first) != text.npos &&
         text.find(second) != text.npos && !gltf_format.looks_so(text, name);
}

namespace {

/// Whether an archive is a SOG. The list of its files is at its end. A streamed SOG is read by its folder
/// alone.
bool is_sog_bundle(std::string_view text) {
  if (!is_zip(text)) return false;
  const std::size_t end = text.size() - std::min(text.size(), beginning_bytes);
  return text.rfind("meta.json") != text.npos && text.substr(end).find("lod-meta.json") == text.npos;
}

bool is_sog_meta(std::string_view text, std::string_view name) {
  return has_sog_keys(text, name, "\"means\"", "\"quats\"");
}

SceneFile read_sog(const Source& source, const SceneReadOptions& options) {
  const ProgressMeter progress(options.progress, source.name);
  progress.report(0);
  SogContent sog = open_sog(source);
  SceneFile file;
  file.format = "SOG version " + std::to_string(sog.meta.version);
  file.bytes = sog.stored - source.bytes.size();
  file.stored = sog.meta.count;
  const SogPixels pixels = decode_images(sog, progress.step(0, 0.5));
  allocate(file.scene, sog.meta.count, sog.sh_degree);
  OriginChoice choice;
  add_box(sog, choice);
  file.scene.origin = choice.origin();
  const SogRange all{0, sog.meta.count, 0};
  SogFindings findings;
  findings.add(sog.meta, decode_gaussians(sog, pixels, all, progress.step(0.5, 1), file.scene));
  findings.finish(file);
  return file;
}

}  // namespace

SceneWriter write_sog;

constinit const SceneFormat sog_format{.name = "a SOG",
                                       .names = {".sog", "meta.json"},
                                       .has_mark = is_sog_bundle,
                                       .looks_so = is_sog_meta,
                                       .read = read_sog,
                                       .write = write_sog,
                                       .place_in_capture = 5};

}  // namespace swiftgs::io
