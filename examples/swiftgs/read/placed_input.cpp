// SPDX-License-Identifier: Apache-2.0
#include "read/placed_input.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>

#include <swiftgs/edit/transform.hpp>

#include "draw/team.hpp"
#include "notes.hpp"
#include "read/scene_input.hpp"

namespace swiftgs::cli {

namespace fs = std::filesystem;

std::vector<ListedScene> scenes_of(const std::vector<std::string>& names, bool place) {
  if (names.size() > 1 && !place)
    throw std::invalid_argument("render: found " + std::to_string(names.size()) +
                                " scenes, expected one, or --place to show all in one frame");
  std::vector<ListedScene> scenes;
  for (const std::string& name : names) {
    if (!is_scene_list(name)) {
      scenes.push_back({.file = name});
      continue;
    }
    Team::here().require_same_file(name);
    for (ListedScene& scene : read_scene_list(name)) {
      if (!builtin_size(scene.file))
        scene.file = (fs::path(name).parent_path() / scene.file).lexically_normal().string();
      scenes.push_back(std::move(scene));
    }
  }
  return scenes;
}

void write_scenes(const std::string& file, std::vector<ListedScene> scenes) {
  const fs::path folder = fs::absolute(file).parent_path().lexically_normal();
  for (ListedScene& scene : scenes) {
    if (builtin_size(scene.file)) continue;
    const fs::path whole = fs::absolute(scene.file).lexically_normal();
    const fs::path relative = whole.lexically_relative(folder);
    scene.file = (relative.empty() ? whole : relative).generic_string();
  }
  write_scene_list(file, scenes);
}

Placement placement_of(const ListedScene& listed, std::size_t scene, const dvec3& origin,
                       const dvec3& of_world) {
  Placement p{.scene = scene,
              .world_from_scene = listed.world_from_scene,
              .opacity = listed.opacity,
              .tint = listed.tint};
  p.world_from_scene.translation = listed.world_from_scene(origin) - of_world;
  for (const HalfSpace& half : listed.half_spaces)
    p.clip.half_spaces[p.clip.half_space_count++] =
        vec4(vec3(half.normal), float(detail::dot(half.normal, origin) - half.offset));
  if (listed.sphere)
    p.clip.centre = vec3(listed.sphere->centre - origin), p.clip.radius = float(listed.sphere->radius);
  p.first = std::size_t(listed.first);
  if (listed.count) p.count = std::size_t(*listed.count);
  if (!listed.visible) p.count = 0;
  return p;
}

namespace {

void open_pages_of(DrawnScenes& drawn, const SceneOptions& options) {
  if (!options.model.empty())
    throw std::invalid_argument("--model " + options.model +
                                ": expected none for pages, which have that of 'swiftgs pages'");
  PagedScene pages = open_pages(options.scene);
  drawn.gaussians.push_back(std::make_shared<const Scene>(pages.read(pages.root()).scene));
  drawn.pages.emplace_back(std::move(pages));
}

}  // namespace

DrawnScenes load_to_place(const std::vector<ListedScene>& scenes, const SceneOptions& reading,
                          std::vector<std::string>& said) {
  DrawnScenes drawn;
  std::vector<std::string> files;
  for (const ListedScene& listed : scenes) {
    const std::size_t known = std::size_t(std::find(files.begin(), files.end(), listed.file) - files.begin());
    if (known == files.size()) {
      SceneOptions options = reading;
      options.scene = listed.file;
      const bool streamed = options.paged && fs::path(listed.file).filename() == "lod-meta.json";
      if (streamed || is_page_file(listed.file)) {
        open_pages_of(drawn, options);
      } else {
        DrawnScene read = load_to_draw(options, said);
        if (files.empty()) drawn.camera = read.camera;
        drawn.gaussians.push_back(std::move(read.gaussians)), drawn.pages.emplace_back();
      }
      files.push_back(listed.file);
    }
    if (drawn.pages[known] && (listed.first != 0 || listed.count))
      throw std::invalid_argument(listed.file + ": found first or count, expected pages to show as a whole");
    drawn.placements.push_back(
        placement_of(listed, known, drawn.gaussians[known]->origin, drawn.gaussians[0]->origin));
  }
  return drawn;
}

bool DrawnScenes::has_pages() const {
  return std::any_of(pages.begin(), pages.end(), [](const auto& each) { return each.has_value(); });
}

void place_views(std::vector<View>& views, const DrawnScenes& drawn) {
  const bool found = views[0].to_find_at > 0;
  place_views(views, *drawn.gaussians[0], drawn.camera);
  if (!found) return;
  for (View& view : views)
    view.camera = transformed(view.camera, drawn.placements[0].world_from_scene), validate(view.camera);
}

}  // namespace swiftgs::cli
