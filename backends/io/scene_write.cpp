// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/io/model_text.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/message.hpp>

#include "name_ending.hpp"
#include "scene_building.hpp"
#include "scene_encoding.hpp"
#include "scene_writers.hpp"

namespace swiftgs {
namespace io {
namespace {

struct Writer {
  std::string_view ending;
  WrittenScene (*write)(const std::filesystem::path&, const Scene&, const SceneWriteOptions&, LossMeter&);
  bool holds_doubles = false;
};

/// The first whose ending fits is taken.
constexpr Writer writers[] = {
    {".compressed.ply", write_compressed_ply},
    {".ply", write_ply, true},
    {".sog", write_sog},
    {".splat", write_splat},
    {".spz", write_spz},
};

const Writer& writer_for(const std::filesystem::path& path, const std::string& ending) {
  const std::string name = ending.empty() ? path.filename().string() : ending;
  std::string endings;
  for (const Writer& writer : writers) {
    if (has_ending(name, writer.ending)) return writer;
    endings += (endings.empty() ? "" : ", ") + std::string(writer.ending);
  }
  detail::refuse(ending.empty() ? path.string() : ending, ": expected a scene's name that ends in one of ",
                 endings);
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
  io::writer_for(path, options.ending);
}

WrittenScene write_scene(const std::filesystem::path& path, const Scene& scene,
                         const SceneWriteOptions& options) {
  const io::Writer& writer = io::writer_for(path, options.ending);
  validate(scene);
  std::vector<std::string> notes;
  const std::optional<Scene> cleaned = io::encodable(scene, notes);
  const Scene& encoded = cleaned ? *cleaned : scene;
  io::LossMeter losses(encoded, scene);
  WrittenScene written = writer.write(path, encoded, options, losses);
  written.losses = losses.losses();
  if (!writer.holds_doubles && scene.origin != dvec3(0.0))
    written.notes.push_back("The origin " + io::text_of(scene.origin) +
                            " is left out: positions in the file are relative to it.");
  io::note_model(scene.model, written.model, written.notes);
  written.notes.insert(written.notes.begin(), notes.begin(), notes.end());
  return written;
}

}  // namespace swiftgs
