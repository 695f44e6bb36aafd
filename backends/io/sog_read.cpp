// SPDX-License-Identifier: Apache-2.0
#include "sog_read.hpp"

#include <string>

#include "scene_building.hpp"
#include "scene_readers.hpp"

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

}  // namespace swiftgs::io
