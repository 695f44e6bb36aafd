// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/frame/harmonics.hpp>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace swiftgs::cli {

/// What says which scene to load.
struct SceneOptions {
  std::string scene;                    ///< a file, the folder of a capture, `builtin`, or `builtin:N`
  std::string spz_frame = "specified";  ///< as `SpzFrame` names them
  int level = 0;                        ///< of detail, in a streamed SOG
  std::string model{};                  ///< what `model_from` takes, in place of what the file says
  bool paged = false;                   ///< draws a streamed SOG by pages
};

/// What says which images to make of it.
struct ViewOptions {
  std::string cameras;  ///< a file or folder of cameras; empty for those in the folder that is the scene
  std::string views;    ///< such as `0,8`, `every:8` or `all`; empty for the command's own choice
  double scale = 1;     ///< of the images' sides
  std::string conventions = "gsplat";
  std::string background = "0,0,0";
  std::string planes;  ///< beside colour, as `add_planes` describes them
};

/// Adds the options of a scene, of which the name is required.
void add_scene(CLI::App& command, SceneOptions& options);

/// Adds `--model`, which changes how a scene is drawn.
void add_model(CLI::App& command, std::string& model);

/// Adds those of them that say how to read it.
void add_scene_reading(CLI::App& command, SceneOptions& options);

/// Adds an option that chooses views; `what` begins its description.
CLI::Option* add_view_choice(CLI::App& command, const char* name, std::string& views,
                             const std::string& what);

/// Names that `--planes` takes, in a sentence. Features are not among them, as no file has any.
std::string names_of_planes();

/// Adds the option of what frames have beside colour.
void add_planes(CLI::App& command, std::string& planes);

/// Adds the options of cameras, the conventions and the background.
void add_cameras(CLI::App& command, ViewOptions& options);

/// Adds these, and which views, how large. `default_views` is what the command takes of a list of cameras.
void add_views(CLI::App& command, ViewOptions& options, const std::string& default_views);

/// Adds the option that names a file for `what`.
void add_json(CLI::App& command, std::string& file, const std::string& what = "the results");

/// Adds the option that says how many views are rendered in one frame.
void add_batch(CLI::App& command, int& batch);

/// Adds the option that says how an upload keeps harmonics.
void add_harmonics(CLI::App& command, std::string& kept);
/// What it says. Throws `InvalidArgument` for an unknown word.
HarmonicsKept harmonics_of(const std::string& kept);

/// Throws `InvalidArgument` for a number of views that no frame has.
void require_batch(int batch);

/// Throws `InvalidArgument` unless `--keep` is a part above 0 and at most 1.
void require_keep(double part);

/// ", did you mean 'NEAREST'?" if one of `known` is near `word`; otherwise nothing.
std::string suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace swiftgs::cli
