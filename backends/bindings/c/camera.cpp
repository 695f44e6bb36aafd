// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>
#include <memory>
#include <numbers>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/camera_matrices.hpp>
#include <swiftgs/default_view.hpp>
#include <swiftgs/io/cameras.hpp>

#include "error.hpp"
#include "objects.hpp"
#include "structs.hpp"

struct swiftgs_cameras {
  swiftgs::CameraFile file;
};

namespace swiftgs::c {
namespace {

constexpr const char* a_camera = "swiftgs_camera";

static_assert(int(LensModel::perspective) == SWIFTGS_LENS_PERSPECTIVE &&
              int(LensModel::fisheye) == SWIFTGS_LENS_FISHEYE &&
              int(LensModel::orthographic) == SWIFTGS_LENS_ORTHOGRAPHIC &&
              int(LensModel::equirectangular) == SWIFTGS_LENS_EQUIRECTANGULAR);

static_assert(int(ClipSpace::opengl) == SWIFTGS_CLIP_OPENGL &&
              int(ClipSpace::vulkan) == SWIFTGS_CLIP_VULKAN &&
              int(ClipSpace::direct3d) == SWIFTGS_CLIP_DIRECT3D);

const CameraFile& file_of(const swiftgs_cameras* cameras) {
  require_pointer(cameras, "cameras");
  return cameras->file;
}

template <class T>
const T& at(const std::vector<T>& list, std::size_t index, const char* what) {
  if (index >= list.size()) refuse(what, ": number ", index, ", expected less than ", list.size());
  return list[index];
}

const Camera& camera_at(const swiftgs_cameras* cameras, std::size_t index) {
  return at(file_of(cameras).cameras, index, "cameras");
}

swiftgs_stored_depth to_struct(const StoredDepth& from) { return {from.p, from.q, from.r, from.s}; }

}  // namespace

dvec3 to_vector(const double (&v)[3]) { return dvec3(v[0], v[1], v[2]); }

Camera to_camera(const swiftgs_camera* given) {
  const swiftgs_camera from = read_struct(given, a_camera);
  require_choice(from.lens, std::int32_t(std::size(lens_traits)), "swiftgs_camera: lens");
  Camera camera;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) camera.rotation[column][row] = from.rotation[3 * row + column];
  camera.translation = to_vector(from.translation);
  camera.fx = from.fx, camera.fy = from.fy, camera.cx = from.cx, camera.cy = from.cy;
  camera.width = from.width, camera.height = from.height;
  camera.lens.model = LensModel(from.lens);
  Distortion& distortion = camera.lens.distortion;
  std::copy(std::begin(from.radial), std::end(from.radial), distortion.radial);
  std::copy(std::begin(from.rational), std::end(from.rational), distortion.rational);
  std::copy(std::begin(from.tangential), std::end(from.tangential), distortion.tangential);
  std::copy(std::begin(from.prism), std::end(from.prism), distortion.prism);
  return camera;
}

void write_camera(swiftgs_camera* given, const Camera& camera) {
  swiftgs_camera to{};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) to.rotation[3 * row + column] = camera.rotation[column][row];
  for (int axis = 0; axis < 3; ++axis) to.translation[axis] = camera.translation[axis];
  to.fx = camera.fx, to.fy = camera.fy, to.cx = camera.cx, to.cy = camera.cy;
  to.width = camera.width, to.height = camera.height;
  to.lens = int(camera.lens.model);
  const Distortion& distortion = camera.lens.distortion;
  std::copy(std::begin(distortion.radial), std::end(distortion.radial), to.radial);
  std::copy(std::begin(distortion.rational), std::end(distortion.rational), to.rational);
  std::copy(std::begin(distortion.tangential), std::end(distortion.tangential), to.tangential);
  std::copy(std::begin(distortion.prism), std::end(distortion.prism), to.prism);
  check_struct(given, a_camera);
  // An older program would take it for a pinhole and draw another image.
  if (given->size < sizeof(to) && !camera.lens.is_pinhole())
    refuse(a_camera, ": size is ", given->size, ", expected ", sizeof(to),
           " for a camera with a lens that is no pinhole: the program is older than the "
           "library");
  write_struct(given, to, a_camera);
}

}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_cameras_read(const char* path, swiftgs_cameras** cameras) {
  return guarded([&] {
    require_pointer(path, "path");
    require_pointer(cameras, "cameras");
    *cameras = std::make_unique<swiftgs_cameras>(swiftgs_cameras{swiftgs::read_cameras(path)}).release();
  });
}

void swiftgs_cameras_free(swiftgs_cameras* cameras) { delete cameras; }

swiftgs_status swiftgs_cameras_count(const swiftgs_cameras* cameras, size_t* count) {
  return guarded([&] {
    const swiftgs::CameraFile& file = file_of(cameras);
    require_pointer(count, "count");
    *count = file.cameras.size();
  });
}

swiftgs_status swiftgs_cameras_get(const swiftgs_cameras* cameras, size_t index, swiftgs_camera* camera) {
  return guarded([&] { write_camera(camera, camera_at(cameras, index)); });
}

swiftgs_status swiftgs_cameras_name(const swiftgs_cameras* cameras, size_t index, const char** name) {
  return guarded([&] {
    require_pointer(name, "name");
    *name = camera_at(cameras, index).name.c_str();
  });
}

swiftgs_status swiftgs_cameras_note_count(const swiftgs_cameras* cameras, size_t* count) {
  return guarded([&] {
    const swiftgs::CameraFile& file = file_of(cameras);
    require_pointer(count, "count");
    *count = file.notes.size();
  });
}

swiftgs_status swiftgs_cameras_note(const swiftgs_cameras* cameras, size_t index, const char** note) {
  return guarded([&] {
    require_pointer(note, "note");
    *note = at(file_of(cameras).notes, index, "notes").c_str();
  });
}

swiftgs_status swiftgs_camera_look_at(const swiftgs_look_at* from, swiftgs_camera* camera) {
  return guarded([&] {
    const swiftgs_look_at look = read_struct(from, "swiftgs_look_at");
    require_zero(look.reserved, "swiftgs_look_at");
    if (!(look.vertical_fov > 0 && look.vertical_fov < std::numbers::pi))
      refuse("swiftgs_look_at: vertical_fov is ", look.vertical_fov,
             ", expected more than 0 and less than pi");
    const swiftgs::Camera made =
        swiftgs::look_at(to_vector(look.eye), to_vector(look.target), to_vector(look.up), look.vertical_fov,
                         look.width, look.height);
    validate(made);
    write_camera(camera, made);
  });
}

swiftgs_status swiftgs_camera_scale(swiftgs_camera* camera, double scale) {
  return guarded([&] {
    const swiftgs::Camera given = to_camera(camera);
    validate(given);
    const swiftgs::Camera made = swiftgs::scaled(given, scale);
    validate(made);
    write_camera(camera, made);
  });
}

swiftgs_stored_depth swiftgs_stored_perspective(double at_0, double at_1) {
  return to_struct(swiftgs::StoredDepth::perspective(at_0, at_1));
}

swiftgs_stored_depth swiftgs_stored_orthographic(double at_0, double at_1) {
  return to_struct(swiftgs::StoredDepth::orthographic(at_0, at_1));
}

swiftgs_status swiftgs_camera_from_matrices(const swiftgs_matrices* from, swiftgs_camera* camera,
                                            swiftgs_stored_depth* stored_depth) {
  return guarded([&] {
    const swiftgs_matrices given = read_struct(from, "swiftgs_matrices");
    require_choice(given.clip_space, 3, "swiftgs_matrices: clip_space");
    const swiftgs::HostCamera host = swiftgs::camera_from(given.view, given.projection, given.width,
                                                          given.height, swiftgs::ClipSpace(given.clip_space));
    write_camera(camera, host.camera);
    if (stored_depth) *stored_depth = to_struct(host.stored_depth);
  });
}

swiftgs_status swiftgs_camera_to_matrices(const swiftgs_camera* camera, int32_t clip_space, double at_0,
                                          double at_1, swiftgs_matrices* matrices) {
  return guarded([&] {
    require_choice(clip_space, 3, "clip_space");
    const swiftgs::Camera given = to_camera(camera);
    const swiftgs::CameraMatrices made = swiftgs::matrices(given, at_0, at_1, swiftgs::ClipSpace(clip_space));
    swiftgs_matrices to{};
    to.clip_space = clip_space, to.width = given.width, to.height = given.height;
    std::copy_n(&made.view[0][0], 16, to.view);
    std::copy_n(&made.projection[0][0], 16, to.projection);
    write_struct(matrices, to, "swiftgs_matrices");
  });
}

swiftgs_status swiftgs_camera_orbit(swiftgs_camera* camera, const swiftgs_orbit* by) {
  return guarded([&] {
    const swiftgs_orbit orbit = read_struct(by, "swiftgs_orbit");
    require_zero(orbit.reserved, "swiftgs_orbit");
    swiftgs::OrbitView view{to_camera(camera), to_vector(orbit.target)};
    validate(view.camera);
    if (const swiftgs::dvec3 up = to_vector(orbit.up); up != swiftgs::dvec3(0.0)) view.up = up;
    const swiftgs::Camera moved =
        swiftgs::orbit(view, orbit.turn, orbit.rise, orbit.distance != 0 ? orbit.distance : 1);
    validate(moved);
    write_camera(camera, moved);
  });
}

swiftgs_status swiftgs_camera_builtin(int32_t width, int32_t height, swiftgs_camera* camera) {
  return guarded([&] {
    const swiftgs::Camera made = swiftgs::builtin_camera(width, height);
    validate(made);
    write_camera(camera, made);
  });
}

}  // extern "C"
