// SPDX-License-Identifier: Apache-2.0
#include "views.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/io/cameras.hpp>

#include "default_view.hpp"
#include "scene_input.hpp"

namespace swiftgs::cli {
namespace {

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0; at != std::string_view::npos;) {
    const std::size_t next = text.find(separator);
    parts.push_back(text.substr(0, next));
    at = next;
    if (next != std::string_view::npos) text.remove_prefix(next + 1);
  }
  return parts;
}

template <class Number>
std::optional<Number> parse(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// The name under which an image of `camera` is stored: folders become part of it, the extension goes.
std::string file_name(const Camera& camera, std::size_t number) {
  std::string name = camera.name;
  const std::size_t dot = name.rfind('.'), slash = name.find_last_of("/\\");
  if (dot != std::string::npos && dot > 0 && (slash == std::string::npos || dot > slash + 1))
    name.resize(dot);
  for (char& c : name)
    if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < ' ') c = '_';
  return name.empty() ? std::to_string(number) : name;
}

/// Every camera there is for the scene, before any is chosen.
std::vector<Camera> all_cameras(const SceneOptions& scene_options, const ViewOptions& options,
                                const Scene& scene) {
  if (!options.cameras.empty()) return read_cameras(options.cameras);
  if (!builtin_size(scene_options.scene)) return {default_view(scene)};
  std::vector<Camera> cameras = builtin_cameras();
  cameras.insert(cameras.begin(), builtin_camera());
  return cameras;
}

/// The cameras called `numbers`, scaled, each with a name of its own.
std::vector<View> views_numbered(const std::vector<Camera>& cameras, const std::vector<std::size_t>& numbers,
                                 double scale) {
  if (!(scale > 0) || !std::isfinite(scale))
    throw std::invalid_argument("--scale: expected a finite scale above 0");
  std::vector<View> views;
  std::set<std::string> names;
  for (const std::size_t number : numbers) {
    View view{scaled(cameras[number], scale), file_name(cameras[number], number)};
    validate(view.camera);
    // Two images must never share a file.
    while (!names.insert(view.name).second) view.name.append("-").append(std::to_string(number));
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace

std::vector<std::size_t> choose_views(std::string_view text, std::size_t count) {
  const auto wrong = [&] {
    return std::invalid_argument(
        "--views '" + std::string(text) + "': expected all, every:N, except:N, or numbers from 0 to " +
        std::to_string(count - 1) + " and ranges of them as 3-7, separated by commas");
  };
  if (count == 0) throw std::invalid_argument("--cameras: expected at least one camera, found none");
  std::vector<std::size_t> chosen;
  const bool every = text.starts_with("every:"), except = text.starts_with("except:");
  if (every || except || text == "all") {
    const std::size_t step =
        text == "all" ? 1 : parse<std::size_t>(text.substr(text.find(':') + 1)).value_or(0);
    if (step == 0) throw wrong();
    for (std::size_t i = 0; i < count; ++i)
      if ((i % step == 0) != except) chosen.push_back(i);
    if (chosen.empty())
      throw std::invalid_argument("--views '" + std::string(text) + "': expected to leave some of " +
                                  std::to_string(count) + " views");
    return chosen;
  }
  for (const std::string_view part : split(text, ',')) {
    const std::vector<std::string_view> ends = split(part, '-');
    const std::optional<std::size_t> first = parse<std::size_t>(ends.front()),
                                     last = parse<std::size_t>(ends.back());
    if (ends.size() > 2 || !first || !last || *first > *last || *last >= count) throw wrong();
    for (std::size_t number = *first; number <= *last; ++number) chosen.push_back(number);
  }
  return chosen;
}

std::vector<View> views_of(const SceneOptions& scene_options, const ViewOptions& options, const Scene& scene,
                           std::string_view default_views) {
  const std::vector<Camera> cameras = all_cameras(scene_options, options, scene);
  std::string_view choice = options.views;
  if (choice.empty()) choice = options.cameras.empty() ? "0" : default_views;
  return views_numbered(cameras, choose_views(choice, cameras.size()), options.scale);
}

std::vector<View> views_left_out(const SceneOptions& scene_options, const ViewOptions& options,
                                 const Scene& scene) {
  const std::vector<Camera> cameras = all_cameras(scene_options, options, scene);
  const std::vector<std::size_t> chosen = choose_views(options.views, cameras.size());
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (std::find(chosen.begin(), chosen.end(), i) == chosen.end()) others.push_back(i);
  return views_numbered(cameras, others, options.scale);
}

RenderSettings settings_of(const ViewOptions& options, const Scene& scene) {
  RenderSettings settings;
  settings.conventions = conventions_named(options.conventions);
  settings.conventions.antialiased = scene.antialiased;
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
