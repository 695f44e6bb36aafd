// SPDX-License-Identifier: Apache-2.0

#include "options.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <type_traits>

#include <CLI/CLI.hpp>

#include <swiftgs/frame.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "words.hpp"

namespace swiftgs::cli {

void add_scene(CLI::App& command, SceneOptions& options) {
  command
      .add_option(
          "SCENE", options.scene,
          std::string("A file, the folder of a capture, builtin, or builtin:N for N Gaussians; files are\n") +
              readable_scenes())
      ->required();
  add_scene_reading(command, options);
}

void add_scene_reading(CLI::App& command, SceneOptions& options) {
  command
      .add_option("--spz-frame", options.spz_frame,
                  "Axes of an .spz file that is read: specified (what the file says, or RUB), rub, rdf,\n"
                  "luf, or raw (its numbers unchanged)")
      ->capture_default_str();
  command.add_option("--level", options.level, "Level of detail of a streamed SOG; 0 is the finest")
      ->capture_default_str();
  add_model(command, options.model);
}

void add_model(CLI::App& command, std::string& model) {
  command.add_option(
      "--model", model,
      "How the scene was trained to be drawn [as the file says]: settings with commas between,\n"
      "of antialiased=yes or no, blur=PIXELS2, order=depth or distance, colours=srgb or linear");
}

CLI::Option* add_view_choice(CLI::App& command, const char* name, std::string& views,
                             const std::string& what) {
  return command.add_option(
      name, views,
      what + ": all, every:8, except:8, or a list of numbers,\nranges and images' names, as 0,3-7,DSC01.JPG");
}

void add_cameras(CLI::App& command, ViewOptions& options) {
  command.add_option("--cameras", options.cameras,
                     "A cameras.json, transforms.json, camera_path.json or COLMAP model, or a\n"
                     "capture's folder [those of SCENE where it is a folder]");
  command
      .add_option("--conventions", options.conventions,
                  "Conventions that the scene was trained with: gsplat, inria or khronos")
      ->capture_default_str();
  command.add_option("--background", options.background, "Colour behind the scene: R,G,B, each 0 to 1")
      ->capture_default_str();
}

void add_views(CLI::App& command, ViewOptions& options, const std::string& default_views) {
  add_cameras(command, options);
  add_view_choice(command, "--views", options.views, "Views")
      ->default_str(default_views + " with cameras, else 0");
  command.add_option("--scale", options.scale, "Factor of the images' sides")->capture_default_str();
}

std::string names_of_planes() {
  std::string names;
  Outputs outputs;
  for_each_plane(
      [&]<class Wanted>(std::size_t, Wanted&, const PlaneRow& row) {
        if constexpr (std::is_same_v<Wanted, bool>)
          names += (names.empty() ? "" : ", ") + std::string(row.name);
      },
      outputs, plane_table);
  return names;
}

void add_planes(CLI::App& command, std::string& planes) {
  std::string names = names_of_planes();
  names[names.find(' ', names.size() / 2)] = '\n';
  command.add_option("--planes", planes,
                     "Planes beside colour, such as alpha,depth [none]; all are\n" + names);
}

void add_json(CLI::App& command, std::string& file, const std::string& what) {
  command.add_option("--json", file,
                     "File for " + what + ";\n- writes to standard output in place of the text");
}

void add_batch(CLI::App& command, int& batch) {
  command.add_option("--batch", batch, "Views that are rendered in one frame")->capture_default_str();
}

void add_harmonics(CLI::App& command, std::string& kept) {
  command
      .add_option("--harmonics", kept,
                  "Spherical harmonics of uploads: smallest, in the fewest bytes that are exact;\n"
                  "float; or half, rounded")
      ->capture_default_str();
}

HarmonicsKept harmonics_of(const std::string& kept) {
  if (kept == "smallest") return HarmonicsKept::smallest;
  if (kept == "float") return HarmonicsKept::floats;
  if (kept == "half") return HarmonicsKept::halves;
  throw std::invalid_argument("--harmonics '" + kept + "': expected smallest, float or half");
}

void require_batch(int batch) {
  if (batch < 1 || std::size_t(batch) > max_views)
    throw std::invalid_argument("--batch " + std::to_string(batch) + ": expected 1 to " +
                                std::to_string(max_views));
}

void require_keep(double part) {
  if (!(part > 0 && part <= 1))
    throw std::invalid_argument("--keep " + text_of_number(part) +
                                ": expected a part of the Gaussians above 0 and at most 1");
}

namespace {

/// How many characters are to be added, left out, replaced or swapped with their neighbour to make one word
/// of the other.
std::size_t edits_between(std::string_view a, std::string_view b) {
  // Rows of the table of distances between beginnings of `a` and of `b`: the last three.
  std::vector<std::size_t> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last.swap(last), last.swap(row);
  }
  return last[b.size()];
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return result;
}

}  // namespace

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
  const std::string* nearest = nullptr;
  // The dashes of an option are no letters of its name.
  const std::size_t letters = word.size() - std::min(word.find_first_not_of('-'), word.size());
  std::size_t least = 1 + letters / 3;
  for (const std::string& name : known)
    if (const std::size_t edits = edits_between(lower(word), lower(name));
        edits < least || (!nearest && edits == least))
      least = edits, nearest = &name;
  return nearest ? ", did you mean '" + *nearest + "'?" : "";
}

}  // namespace swiftgs::cli
