// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/default_view.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/tools/scene_bounds.hpp>

#include "error.hpp"
#include "objects.hpp"
#include "structs.hpp"

namespace swiftgs::c {
namespace {

static_assert(int(SpzFrame::specified) == SWIFTGS_SPZ_SPECIFIED && int(SpzFrame::rub) == SWIFTGS_SPZ_RUB &&
              int(SpzFrame::rdf) == SWIFTGS_SPZ_RDF && int(SpzFrame::luf) == SWIFTGS_SPZ_LUF &&
              int(SpzFrame::raw) == SWIFTGS_SPZ_RAW);

SpzFrame to_spz_frame(std::int32_t axes, const char* what) {
  require_choice(axes, 5, what);
  return SpzFrame(axes);
}

Progress to_progress(swiftgs_progress progress, void* context) {
  if (!progress) return {};
  return [=](double part) { return progress(context, part) == 0; };
}

SceneReadOptions to_options(const swiftgs_read_options& from) {
  require_zero(from.reserved, "swiftgs_read_options");
  return {to_spz_frame(from.spz_axes, "swiftgs_read_options: spz_axes"), from.level,
          to_progress(from.progress, from.context)};
}

SceneWriteOptions to_options(const swiftgs_write_options& from) {
  require_zero(from.reserved, "swiftgs_write_options");
  SceneWriteOptions options;
  if (from.ending) options.ending = from.ending;
  if (from.spz_version != 0) options.spz_version = from.spz_version;
  options.spz_frame = to_spz_frame(from.spz_axes, "swiftgs_write_options: spz_axes");
  options.progress = to_progress(from.progress, from.context);
  return options;
}

template <class Options>
void hand_over(const std::vector<std::string>& notes, const Options& to) {
  if (to.note)
    for (const std::string& note : notes) to.note(to.context, note.c_str());
}

swiftgs_scene* own(swiftgs_scene scene) {
  return std::make_unique<swiftgs_scene>(std::move(scene)).release();
}

swiftgs_scene* own(SceneFile file, const swiftgs_read_options& options) {
  hand_over(file.notes, options);
  return own({std::make_shared<const Scene>(std::move(file.scene)), std::move(file.format), file.stored,
              file.left_out.total(), file.camera});
}

swiftgs_scene* own(Scene scene) {
  const std::uint64_t count = scene.size();
  return own({std::make_shared<const Scene>(std::move(scene)), {}, count});
}

swiftgs_scene_info info_of(const swiftgs_scene& from) {
  const Scene& scene = *from.scene;
  swiftgs_scene_info info{};
  info.sh_degree = scene.sh_degree;
  info.count = scene.size(), info.stored = from.stored, info.dropped = from.dropped;
  set_model(info, scene.model), info.feature_channels = scene.feature_channels;
  info.format = from.format.c_str();
  for (int axis = 0; axis < 3; ++axis) info.origin[axis] = scene.origin[axis];
  bool found = false;
  for (const vec3& mean : scene.means) {
    if (!swiftgs::detail::is_finite(mean)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      info.lower[axis] = found ? std::min(info.lower[axis], mean[axis]) : mean[axis];
      info.upper[axis] = found ? std::max(info.upper[axis], mean[axis]) : mean[axis];
    }
    found = true;
  }
  return info;
}

void copy_vector(double (&to)[3], const dvec3& from) {
  for (int axis = 0; axis < 3; ++axis) to[axis] = from[axis];
}

/// `size`: of the caller's struct. One that has no place for features is told of none.
swiftgs_gaussians arrays_of(const Scene& scene, std::size_t size) {
  swiftgs_gaussians arrays{};
  arrays.sh_degree = scene.sh_degree, arrays.feature_channels = scene.feature_channels;
  arrays.count = scene.size();
  set_model(arrays, scene.model);
  for_each_array(
      [](const char*, std::size_t each, const auto& from, swiftgs_array& to) {
        if (!from.empty()) to = {swiftgs::detail::floats_of(from).data, std::int64_t(each * sizeof(from[0]))};
      },
      scene, arrays);
  for (int axis = 0; axis < 3; ++axis) arrays.origin[axis] = scene.origin[axis];
  if (size < offsetof(swiftgs_gaussians, origin)) arrays.feature_channels = 0;
  if (size < offsetof(swiftgs_gaussians, blur) && scene.origin != dvec3(0.0))
    refuse("swiftgs_gaussians: size is ", size,
           ", expected room for the origin of a scene far from zero: the program is older than origins");
  return arrays;
}

}  // namespace
}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_scene_read(const char* path, const swiftgs_read_options* options,
                                  swiftgs_scene** scene) {
  return guarded([&] {
    require_pointer(path, "path");
    require_pointer(scene, "scene");
    const swiftgs_read_options read = read_options(options, "swiftgs_read_options");
    *scene = own(swiftgs::read_scene(path, to_options(read)), read);
  });
}

swiftgs_status swiftgs_scene_read_bytes(const swiftgs_file_bytes* bytes, const swiftgs_read_options* options,
                                        swiftgs_scene** scene) {
  return guarded([&] {
    const swiftgs_file_bytes file = read_struct(bytes, "swiftgs_file_bytes");
    require_zero(file.reserved, "swiftgs_file_bytes");
    require_pointer(file.name, "swiftgs_file_bytes: name");
    if (file.count != 0) require_pointer(file.data, "swiftgs_file_bytes: data");
    require_pointer(scene, "scene");
    const swiftgs_read_options read = read_options(options, "swiftgs_read_options");
    const std::span content(static_cast<const std::byte*>(file.data), std::size_t(file.count));
    *scene = own(swiftgs::read_scene(content, file.name, to_options(read)), read);
  });
}

swiftgs_status swiftgs_scene_from_arrays(const swiftgs_gaussians* gaussians, swiftgs_scene** scene) {
  return guarded([&] {
    require_pointer(scene, "scene");
    *scene = own(to_scene(gaussians));
  });
}

swiftgs_status swiftgs_scene_builtin(uint64_t count, swiftgs_scene** scene) {
  return guarded([&] {
    require_pointer(scene, "scene");
    if (count > std::numeric_limits<std::uint32_t>::max())
      refuse("scene: ", count, " Gaussians, expected fewer than 2^32");
    *scene = own(swiftgs::make_builtin_scene(std::size_t(count)));
  });
}

void swiftgs_scene_free(swiftgs_scene* scene) { delete scene; }

swiftgs_status swiftgs_scene_get_info(const swiftgs_scene* scene, swiftgs_scene_info* info) {
  return guarded([&] {
    require_pointer(scene, "scene");
    check_struct(info, "swiftgs_scene_info");
    write_struct(info, info_of(*scene), "swiftgs_scene_info");
  });
}

swiftgs_status swiftgs_scene_get_arrays(const swiftgs_scene* scene, swiftgs_gaussians* gaussians) {
  return guarded([&] {
    require_pointer(scene, "scene");
    check_struct(gaussians, "swiftgs_gaussians");
    write_struct(gaussians, arrays_of(*scene->scene, gaussians->size), "swiftgs_gaussians");
  });
}

swiftgs_status swiftgs_scene_get_camera(const swiftgs_scene* scene, swiftgs_camera* camera) {
  return guarded([&] {
    require_pointer(scene, "scene");
    if (scene->camera)
      write_camera(camera, *scene->camera);
    else
      write_struct(camera, swiftgs_camera{}, "swiftgs_camera");
  });
}

swiftgs_status swiftgs_scene_robust_bounds(const swiftgs_scene* scene, swiftgs_scene_bounds* bounds) {
  return guarded([&] {
    require_pointer(scene, "scene");
    check_struct(bounds, "swiftgs_scene_bounds");
    const swiftgs::SceneBounds found = swiftgs::robust_bounds(*scene->scene);
    swiftgs_scene_bounds to{};
    copy_vector(to.low, found.low), copy_vector(to.high, found.high), copy_vector(to.centre, found.centre);
    to.radius = found.radius;
    write_struct(bounds, to, "swiftgs_scene_bounds");
  });
}

swiftgs_status swiftgs_scene_default_view(const swiftgs_scene* scene, int32_t width, int32_t height,
                                          swiftgs_camera* camera, swiftgs_orbit* orbit) {
  return guarded([&] {
    require_pointer(scene, "scene");
    swiftgs_orbit given = read_options(orbit, "swiftgs_orbit");
    require_zero(given.reserved, "swiftgs_orbit");
    const swiftgs::OrbitView found = swiftgs::default_view(*scene->scene, width, height, to_vector(given.up));
    validate(found.camera);
    write_camera(camera, found.camera);
    copy_vector(given.target, found.target), copy_vector(given.up, found.up);
    if (orbit) write_struct(orbit, given, "swiftgs_orbit");
  });
}

swiftgs_status swiftgs_scene_write(const swiftgs_scene* scene, const char* path,
                                   const swiftgs_write_options* options) {
  return guarded([&] {
    require_pointer(scene, "scene");
    require_pointer(path, "path");
    const swiftgs_write_options write = read_options(options, "swiftgs_write_options");
    swiftgs::WrittenScene written = swiftgs::write_scene(path, *scene->scene, to_options(write));
    if (const std::string losses = text_of(written.losses); !losses.empty())
      written.notes.push_back("Rounding changes numbers at most: " + losses + ".");
    hand_over(written.notes, write);
  });
}

}  // extern "C"
