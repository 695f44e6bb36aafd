// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/io/scene_list.hpp>
#include <swiftgs/pages/paged_scene.hpp>
#include <swiftgs/scene.hpp>

#include "options.hpp"
#include "read/views.hpp"

namespace swiftgs::cli {

/// The scenes of one frame. `names` are files of scenes, or lists, whose paths are relative to the list.
/// Reads lists alone. Throws `InvalidArgument` for several names unless `place` says that one frame
/// shows all.
std::vector<ListedScene> scenes_of(const std::vector<std::string>& names, bool place);

/// Writes the list `file` of `scenes`, whose names are those that `scenes_of` returns. Throws as
/// `write_scene_list`.
void write_scenes(const std::string& file, std::vector<ListedScene> scenes);

/// Of a scene whose positions lack `origin`, in a world that lacks `of_world`. Nothing shows of a hidden one.
Placement placement_of(const ListedScene& listed, std::size_t scene, const dvec3& origin,
                       const dvec3& of_world);

/// Scenes of one frame to draw. The world's zero is where the first one's means have theirs.
struct DrawnScenes {
  std::vector<std::shared_ptr<const Scene>> gaussians;  ///< each file once; of pages those of the root
  std::vector<std::optional<PagedScene>> pages;         ///< of each of `gaussians`
  std::vector<Placement> placements;
  std::optional<Camera> camera;  ///< that the first file has

  bool has_pages() const;
};

/// Loads `scenes` as `reading` says, as `load_to_draw` does.
DrawnScenes load_to_place(const std::vector<ListedScene>& scenes, const SceneOptions& reading,
                          std::vector<std::string>& said);

/// `place_views` of the first scene. A view that is found for it goes where the scene goes.
void place_views(std::vector<View>& views, const DrawnScenes& drawn);

}  // namespace swiftgs::cli
