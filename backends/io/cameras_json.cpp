// SPDX-License-Identifier: Apache-2.0
#include "camera_entry.hpp"
#include "camera_parsing.hpp"

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

}  // namespace swiftgs::io
