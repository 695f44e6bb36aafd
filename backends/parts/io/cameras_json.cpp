// SPDX-License-Identifier: Apache-2.0

#include <numbers>
#include <string>

#include "camera_parsing.hpp"
#include "text.hpp"

namespace swiftgs::io {
namespace {

/// What a camera is asked for, and its number, which no picture shows.
constexpr std::string_view item_keys[] = {"id", "img_name", "width", "height",   "fx",
                                          "fy", "cx",       "cy",    "position", "rotation"};

/// Throws `FormatError` that lists the keys unless `entry` has the name that INRIA's cameras have.
void expect_inria(const JsonEntry& entry) {
  if (entry.has("img_name")) return;
  entry.fail("a camera with 'img_name', as INRIA's cameras.json has, found " + listed_keys(entry.members()));
}

Camera camera_of(const JsonEntry& entry) {
  expect_inria(entry);
  const Source& source = entry.source();
  Camera camera;
  camera.lens = lens_of({entry, entry});
  camera.name = entry.string("img_name");
  camera.width = to_side(source, entry.offset(), entry.number("width"));
  camera.height = to_side(source, entry.offset(), entry.number("height"));
  if (traits_of(camera.lens.model).shows_sphere) {
    show_sphere(camera, camera.width, camera.height);
  } else {
    camera.fx = entry.number("fx"), camera.fy = entry.number("fy");
    // INRIA's training writes no principal point; others add one.
    camera.cx = entry.has("cx") ? entry.number("cx") : 0.5 * camera.width;
    camera.cy = entry.has("cy") ? entry.number("cy") : 0.5 * camera.height;
  }
  set_pose(camera, entry.matrix("rotation"), entry.vector("position"));
  expect_valid(source, entry.offset(), camera);
  return camera;
}

}  // namespace

CameraFile parse_cameras_json(const Source& source) {
  const nlohmann::json root = parse_json(source);
  if (!root.is_array()) source.fail(0, "an array of cameras, as INRIA's cameras.json has");
  CameraFile file;
  UnreadKeys unread(item_keys);
  file.cameras.reserve(root.size());
  const std::vector<std::uint64_t> offsets = offsets_in(source.text(), source.text().find('['));
  for (std::size_t i = 0; i < root.size(); ++i) {
    const JsonEntry entry(source, root[i], offsets[i], "a camera");
    file.cameras.push_back(camera_of(entry));
    unread.add(entry);
  }
  unread.note(file.notes);
  return file;
}

namespace {

/// Keys of a camera path and of its frames: those that are read, and those that only nerfstudio's editor
/// uses. The size of all frames is the path's.
constexpr std::string_view path_keys[] = {
    "camera_path",  "camera_to_world", "camera_type", "fov",          "render_height",
    "render_width", "aspect",          "default_fov", "default_time", "default_transition_sec",
    "fps",          "is_cycle",        "keyframes",   "seconds",      "smoothness_value"};

LensModel lens_model_of(const JsonEntry& root) {
  if (!root.has("camera_type")) return LensModel::perspective;
  const std::string name = root.string("camera_type");
  for (const LensModel model : {LensModel::perspective, LensModel::fisheye, LensModel::equirectangular})
    if (name == name_of(model)) return model;
  root.fail("'camera_type' to be perspective, fisheye or equirectangular, found " + listed({name}));
}

Camera camera_of(const JsonEntry& root, const JsonEntry& frame) {
  Camera camera;
  camera.lens.model = lens_model_of(root);
  camera.width = to_side(root.source(), root.offset(), root.number("render_width"));
  camera.height = to_side(root.source(), root.offset(), root.number("render_height"));
  if (traits_of(camera.lens.model).shows_sphere) {
    show_sphere(camera, camera.width, camera.height);
  } else {
    // nerfstudio takes a fisheye lens's focal length as if it were a pinhole's.
    camera.fx = camera.fy = length_of_angle(frame, "fov", std::numbers::pi / 180, camera.height);
    camera.cx = 0.5 * camera.width, camera.cy = 0.5 * camera.height;
  }
  const auto [axes, centre] = frame.flat_affine("camera_to_world");
  set_opengl_pose(camera, axes, centre);
  expect_valid(frame.source(), frame.offset(), camera);
  return camera;
}

double frames_a_second_of(const JsonEntry& root) {
  constexpr double usual = 24;  // nerfstudio's own
  const double rate = root.has("fps") ? root.number("fps") : usual;
  if (!(rate > 0 && rate <= 1000)) root.fail("'fps' to be above 0 and at most 1000");
  return rate;
}

}  // namespace

CameraFile parse_camera_path(const Source& source) {
  const nlohmann::json value = parse_json(source);
  const JsonEntry root(source, value, 0, "a camera_path.json");
  const nlohmann::json& frames = root.member("camera_path");
  if (!frames.is_array()) root.fail("'camera_path' to be an array");
  const std::string_view text = source.text();
  const std::vector<std::uint64_t> offsets =
      offsets_in(text, offset_of_member(text, text.find('{'), "camera_path"));
  CameraFile file;
  file.frames_a_second = frames_a_second_of(root);
  UnreadKeys unread(path_keys);
  unread.add(root);
  file.cameras.reserve(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const JsonEntry frame(source, frames[i], offsets[i], "a frame");
    file.cameras.push_back(camera_of(root, frame));
    unread.add(frame);
  }
  unread.note(file.notes);
  return file;
}

}  // namespace swiftgs::io
