// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/io/model_text.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/message.hpp>

#include "listed.hpp"
#include "name_ending.hpp"
#include "scene_building.hpp"
#include "scene_encoding.hpp"
#include "scene_format.hpp"

namespace swiftgs {
namespace io {
namespace {

/// The format whose ending `path` has: of `.compressed.ply` and `.ply` the longer one.
const SceneFormat& format_for(const std::filesystem::path& path, const std::string& ending) {
  const std::string name = ending.empty() ? path.filename().string() : ending;
  const SceneFormat* found = nullptr;
  std::vector<std::string> endings;
  for (const SceneFormat* format : scene_formats) {
    if (!format->write) continue;
    endings.emplace_back(format->names[0]);
    if (has_ending(name, format->names[0]) && (!found || format->names[0].size() > found->names[0].size()))
      found = format;
  }
  if (found) return *found;
  std::sort(endings.begin(), endings.end());
  detail::refuse(ending.empty() ? path.string() : ending, ": expected a scene's name that ends in one of ",
                 listed(endings));
}

/// Tells what of a scene's model the file does not hold.
void note_model(RenderingModel model, const RenderingModel& kept, std::vector<std::string>& notes) {
  if (model == kept) return;
  const RenderingModel usual;
  if (model.blur == kept.blur) model.blur = usual.blur;
  if (model.antialiased == kept.antialiased) model.antialiased = usual.antialiased;
  if (model.order == kept.order) model.order = usual.order;
  if (model.colours == kept.colours) model.colours = usual.colours;
  if (model.kernel == kept.kernel) model.kernel = usual.kernel;
  notes.push_back("How the scene was trained to be drawn is left out: " + text_of(model) + ".");
}

}  // namespace
}  // namespace io

void require_scene_ending(const std::filesystem::path& path, const SceneWriteOptions& options) {
  io::format_for(path, options.ending);
}

WrittenScene write_scene(const std::filesystem::path& path, const Scene& scene,
                         const SceneWriteOptions& options) {
  const io::SceneFormat& format = io::format_for(path, options.ending);
  validate(scene);
  std::vector<std::string> notes;
  const std::optional<Scene> cleaned = io::encodable(scene, notes);
  const Scene& encoded = cleaned ? *cleaned : scene;
  io::LossMeter losses(encoded, scene);
  WrittenScene written = format.write(path, encoded, options, losses);
  written.losses = losses.losses();
  if (!format.holds_doubles && scene.origin != dvec3(0.0))
    written.notes.push_back("The origin " + io::text_of(scene.origin) +
                            " is left out: positions in the file are relative to it.");
  io::note_model(scene.model, written.model, written.notes);
  written.notes.insert(written.notes.begin(), notes.begin(), notes.end());
  return written;
}

}  // namespace swiftgs
