// SPDX-License-Identifier: Apache-2.0
#include "read/views.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <stdexcept>
#include <type_traits>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/default_view.hpp>
#include <swiftgs/edit/transform.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/io/cameras.hpp>

#include "draw/image_name.hpp"
#include "draw/team.hpp"
#include "notes.hpp"
#include "options.hpp"
#include "read/scene_input.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

/// The name under which an image of `camera` is stored: folders become part of it, the extension goes.
std::string file_name(const Camera& camera, std::size_t number) {
  std::string_view path = without_extension(camera.name);
  // Without these, which lead to the image, the file would be hidden.
  while (path.starts_with("./") || path.starts_with("../")) path.remove_prefix(path.find('/') + 1);
  std::string name(path);
  for (char& c : name)
    if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < ' ') c = '_';
  return name.empty() ? std::to_string(number) : name;
}

/// The numbers of the cameras of the image that is called `name`, in full, without extension, as the file is
/// called that it is rendered to, or without its folders.
std::vector<std::size_t> cameras_called(std::string_view name, const std::vector<Camera>& cameras) {
  std::vector<std::size_t> in_full, in_part, alone;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].name == name) in_full.push_back(i);
    if (without_extension(cameras[i].name) == name || file_name(cameras[i], i) == name) in_part.push_back(i);
    const std::string_view file = std::string_view(cameras[i].name).substr(cameras[i].name.rfind('/') + 1);
    if (file == name || without_extension(file) == name) alone.push_back(i);
  }
  return !in_full.empty() ? in_full : !in_part.empty() ? in_part : alone;
}

/// The numbers that `text`, as `8` or `3-7`, stands for, or none.
std::vector<std::size_t> numbers_in(std::string_view text, std::size_t count) {
  const std::vector<std::string_view> ends = split(text, '-');
  const std::optional<std::size_t> first = parse<std::size_t>(ends.front()),
                                   last = parse<std::size_t>(ends.back());
  std::vector<std::size_t> numbers;
  if (ends.size() > 2 || !first || !last || *last >= count) return numbers;
  for (std::size_t number = *first; number <= *last; ++number) numbers.push_back(number);
  return numbers;
}

/// The cameras that one part of a list chooses, or none.
std::vector<std::size_t> cameras_at(std::string_view part, const std::vector<Camera>& cameras) {
  // Images are often called 0001, 0002 and so on.
  const bool name_first = part.size() > 1 && part.starts_with('0');
  std::vector<std::size_t> called;
  if (name_first) called = cameras_called(part, cameras);
  if (called.empty()) called = numbers_in(part, cameras.size());
  return called.empty() ? cameras_called(part, cameras) : called;
}

/// Suggests an image for a name that none has, unless it is a number.
std::string nearest_name(std::string_view name, const std::vector<Camera>& cameras) {
  if (name.find_first_not_of("0123456789-") == name.npos) return {};
  std::vector<std::string> known;
  for (const Camera& camera : cameras) {
    known.push_back(camera.name);
    known.emplace_back(without_extension(camera.name));
  }
  return suggestion(name, known);
}

/// Of all numbers and names.
std::size_t checksum_of(const std::vector<Camera>& cameras) {
  std::string packed;
  for (const Camera& camera : cameras) {
    pack(packed, camera.rotation), pack(packed, camera.translation), pack(packed, camera.name);
    for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) pack(packed, value);
    pack(packed, camera.width), pack(packed, camera.height);
    pack(packed, camera.lens.model), pack(packed, camera.lens.distortion);
  }
  return std::hash<std::string>()(packed);
}

/// The cameras called `numbers`, scaled, each with a name of its own.
std::vector<View> views_numbered(const Cameras& cameras, const std::vector<std::size_t>& numbers,
                                 double scale) {
  if (!(scale > 0) || !std::isfinite(scale))
    throw std::invalid_argument("--scale " + text_of_number(scale) + ": expected a finite scale above 0");
  std::vector<View> views;
  std::set<std::string> names;
  for (const std::size_t number : numbers) {
    const Camera& camera = cameras.all[number];
    View view{scaled(camera, scale), file_name(camera, number), cameras.to_find ? scale : 0};
    validate(view.camera);
    // Two images must never share a file.
    while (!names.insert(view.name).second) view.name.append("-").append(std::to_string(number));
    views.push_back(std::move(view));
  }
  return views;
}

/// The view of a scene that comes without cameras.
Camera found_camera(const Scene& scene) {
  Camera camera = default_view(scene).camera;
  camera.name = "view";
  return camera;
}

}  // namespace

Cameras read_cameras_of(const SceneOptions& scene, const std::string& cameras,
                        std::vector<std::string>& said) {
  const std::string file = cameras_of(scene, cameras);
  Cameras result;
  if (!file.empty()) {
    CameraFile read = read_cameras(cameras.empty() ? scene.scene : cameras);
    result.all = std::move(read.cameras), result.of_file = true;
    if (read.frames_a_second > 0) result.frames_a_second = read.frames_a_second;
    say_notes(file, read.notes, said);
    if (result.all.empty()) throw std::invalid_argument(file + ": expected at least one camera, found none");
  } else if (builtin_size(scene.scene)) {
    result.all = builtin_cameras();
    result.all.insert(result.all.begin(), builtin_camera());
  } else {
    result.all = {found_camera(Scene())}, result.to_find = true;
  }
  Team::here().require_same("the checksum of the cameras", std::to_string(checksum_of(result.all)));
  return result;
}

std::vector<std::size_t> choose_views(std::string_view text, const std::vector<Camera>& cameras) {
  const std::size_t count = cameras.size();
  const std::string option = "--views '" + std::string(text) + "': ";
  const auto wrong = [&] {
    return std::invalid_argument(
        option + "expected all, every:N, except:N, or names of images, numbers from 0 to " +
        std::to_string(count - 1) + " and ranges of them as 3-7, separated by commas");
  };
  std::vector<std::size_t> chosen;
  const bool every = text.starts_with("every:"), except = text.starts_with("except:");
  if (every || except || text == "all") {
    const std::size_t step =
        text == "all" ? 1 : parse<std::size_t>(text.substr(text.find(':') + 1)).value_or(0);
    if (step == 0) throw wrong();
    for (std::size_t i = 0; i < count; ++i)
      if ((i % step == 0) != except) chosen.push_back(i);
    if (chosen.empty())
      throw std::invalid_argument(option + "expected to leave some of " + std::to_string(count) + " views");
    return chosen;
  }
  for (const std::string_view part : split(text, ',')) {
    const std::vector<std::size_t> numbers = cameras_at(part, cameras);
    chosen.insert(chosen.end(), numbers.begin(), numbers.end());
    if (!numbers.empty()) continue;
    const std::string nearest = nearest_name(part, cameras);
    if (nearest.empty()) throw wrong();
    throw std::invalid_argument(option + "no image is called '" + std::string(part) + "'" + nearest);
  }
  return chosen;
}

std::vector<View> views_of(const Cameras& cameras, const ViewOptions& options,
                           std::string_view default_views) {
  std::string_view choice = options.views;
  if (choice.empty()) choice = cameras.of_file ? default_views : "0";
  return views_numbered(cameras, choose_views(choice, cameras.all), options.scale);
}

std::vector<View> views_left_out(const Cameras& cameras, const ViewOptions& options) {
  const std::vector<std::size_t> chosen = choose_views(options.views, cameras.all);
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < cameras.all.size(); ++i)
    if (std::find(chosen.begin(), chosen.end(), i) == chosen.end()) others.push_back(i);
  return views_numbered(cameras, others, options.scale);
}

void place_views(std::vector<View>& views, const Scene& scene, const std::optional<Camera>& of_file) {
  const bool moved = scene.origin != dvec3(0.0);
  for (View& view : views) {
    const bool found = view.to_find_at > 0, in_scene = found && !of_file;
    if (found)
      view.camera = scaled(of_file ? *of_file : found_camera(scene), view.to_find_at), view.to_find_at = 0;
    if (moved && !in_scene) view.camera = transformed(view.camera, {.translation = -scene.origin});
    if (found || moved) validate(view.camera);
  }
}

Outputs planes_of(const std::string& text) {
  Outputs planes;
  if (text.empty()) return planes;
  for (const std::string_view name : split(text, ',')) {
    bool added = false;
    for_each_plane(
        [&]<class Wanted>(std::size_t, const PlaneRow& row, Wanted& wanted) {
          if constexpr (std::is_same_v<Wanted, bool>)
            if (name == row.name && !wanted) added = wanted = true;
        },
        plane_table, planes);
    if (!added)
      throw std::invalid_argument("--planes '" + text + "': expected names, with commas between, of " +
                                  names_of_planes() + "; each once");
  }
  return planes;
}

RenderSettings settings_of(const ViewOptions& options) {
  RenderSettings settings;
  settings.outputs = planes_of(options.planes);
  settings.conventions = conventions_named(options.conventions);
  const std::vector<std::string_view> parts = split(options.background, ',');
  for (std::size_t c = 0; c < 3; ++c) {
    const std::optional<float> value = parts.size() == 3 ? parse<float>(parts[c]) : std::nullopt;
    if (!value || !(*value >= 0 && *value <= 1))
      throw std::invalid_argument("--background '" + options.background +
                                  "': expected three numbers R,G,B of 0 to 1 each, such as 1,1,1");
    settings.background[int(c)] = *value;
  }
  return settings;
}

}  // namespace swiftgs::cli
