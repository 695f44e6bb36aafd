// SPDX-License-Identifier: Apache-2.0

// Placed scenes.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include <swiftgs/any_renderer.hpp>

#include "error.hpp"
#include "objects.hpp"
#include "structs.hpp"

namespace swiftgs::c {
namespace {

static_assert(std::size(swiftgs_placement{}.half_spaces) == 4 * Clip::max_half_spaces);

Clip to_clip(const swiftgs_placement& from) {
  Clip clip;
  clip.half_space_count = from.half_space_count;
  for (int i = 0; i < Clip::max_half_spaces; ++i)
    for (int k = 0; k < 4; ++k) clip.half_spaces[i][k] = from.half_spaces[4 * i + k];
  clip.centre = vec3(from.centre[0], from.centre[1], from.centre[2]);
  if (from.radius != 0) clip.radius = from.radius;
  return clip;
}

static_assert(sizeof(dmat3) == 9 * sizeof(double) && sizeof(dvec3) == 3 * sizeof(double));
static_assert(offsetof(Tint, amount) == 3 * sizeof(float));

/// Addresses alone: the memory may be a device's.
swiftgs_recorded_scenes to_struct(Span<StoredScene> scenes) {
  StoredScene& first = *scenes.data;
  return {.size = 0,
          .reserved = 0,
          .count = scenes.size,
          .stride = sizeof(StoredScene),
          .rotation = &first.world_from_scene.rotation[0].x,
          .scale = &first.world_from_scene.scale,
          .translation = &first.world_from_scene.translation.x,
          .opacity = &first.opacity,
          .tint = &first.tint.colour.x};
}

void require_count(const char* call, std::size_t count, std::size_t scenes) {
  if (count != scenes)
    refuse(call, ": count is ", count, ", expected ", scenes, ", the placed scenes of the frame");
}

}  // namespace

Placement to_placement(const swiftgs_placement& from) {
  if (!(from.transparency >= 0 && from.transparency <= 1))
    refuse("swiftgs_placement: transparency is ", from.transparency, ", expected 0 to 1");
  Placement to;
  to.scene = std::size_t(from.scene);
  Similarity& pose = to.world_from_scene;
  if (std::any_of(std::begin(from.rotation), std::end(from.rotation), [](double each) { return each != 0; }))
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) pose.rotation[column][row] = from.rotation[3 * row + column];
  if (from.scale != 0) pose.scale = from.scale;
  for (int axis = 0; axis < 3; ++axis) pose.translation[axis] = from.translation[axis];
  to.opacity = float(1 - from.transparency);
  to.clip = to_clip(from);
  to.first = std::size_t(from.first);
  if (from.count == Placement::all)  // as -1 is stored; C++ takes it for all
    refuse("swiftgs_placement: count is ", from.count, ", expected fewer, or 0 for all");
  if (from.count != 0) to.count = std::size_t(from.count);
  to.tint = {vec3(from.tint[0], from.tint[1], from.tint[2]), from.tint_amount};
  return to;
}

}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_renderer_add_scene(swiftgs_renderer* renderer, const swiftgs_scene* scene,
                                          std::uint64_t* number) {
  return guarded([&] {
    require_pointer(scene, "scene");
    require_pointer(number, "number");
    const Turn any = of(renderer);
    *number = any->add_scene(scene->scene, renderer->harmonics);
    renderer->shown.reset();
  });
}

swiftgs_status swiftgs_renderer_place(swiftgs_renderer* renderer, const swiftgs_placement* placements,
                                      std::size_t count) {
  return guarded([&] {
    const Turn any = of(renderer);
    std::vector<swiftgs::Placement> all;
    for_each_struct(placements, count, "swiftgs_placement",
                    [&](const swiftgs_placement& each) { all.push_back(to_placement(each)); });
    any->place({all.data(), all.size()});
    renderer->shown.reset();
  });
}

swiftgs_status swiftgs_renderer_set_recorded_scenes(swiftgs_renderer* renderer) {
  return guarded([&] {
    const Turn any = of(renderer);
    any->set_recorded_scenes();
    renderer->recorded = renderer->shown;
  });
}

swiftgs_status swiftgs_renderer_recorded_scenes(swiftgs_renderer* renderer, swiftgs_recorded_scenes* scenes) {
  return guarded([&] {
    const Turn any = of(renderer);
    check_struct(scenes, "swiftgs_recorded_scenes");
    write_struct(scenes, to_struct(any->recorded_scenes()), "swiftgs_recorded_scenes");
  });
}

swiftgs_status swiftgs_renderer_refused_scenes(swiftgs_renderer* renderer, std::uint8_t* refused,
                                               std::size_t count) {
  return guarded([&] {
    const Turn any = of(renderer);
    require_pointer(refused, "refused");
    require_count("refused_scenes", count, any->recorded_scenes().size);
    const std::vector<std::size_t> found = any->refused_scenes();
    std::fill_n(refused, count, std::uint8_t(0));
    for (const std::size_t scene : found) refused[scene] = 1;
  });
}

swiftgs_status swiftgs_renderer_visible_by_scene(const swiftgs_renderer* renderer, std::uint64_t* visible,
                                                 std::size_t count) {
  return guarded([&] {
    const Turn any = of(renderer);
    require_pointer(visible, "visible");
    const std::vector<std::size_t> found = any->visible_by_scene();
    require_count("visible_by_scene", count, found.size());
    std::copy(found.begin(), found.end(), visible);
  });
}

}  // extern "C"
