// SPDX-License-Identifier: Apache-2.0
#include "camera_parsing.hpp"
#include "json_entry.hpp"

namespace swiftgs::io {
namespace {

Camera camera_of(const JsonEntry& entry) {
  const Source& source = entry.source();
  Camera camera;
  camera.name = entry.string("img_name");
  camera.width = to_side(source, entry.offset(), entry.number("width"));
  camera.height = to_side(source, entry.offset(), entry.number("height"));
  camera.fx = entry.number("fx"), camera.fy = entry.number("fy");
  camera.cx = 0.5 * camera.width, camera.cy = 0.5 * camera.height;
  set_pose(camera, entry.matrix("rotation"), entry.vector("position"));
  expect_valid(source, entry.offset(), camera);
  return camera;
}

}  // namespace

std::vector<Camera> parse_cameras_json(const Source& source) {
  const nlohmann::json root = parse_json(source);
  if (!root.is_array()) source.fail(0, "an array of cameras, as INRIA's cameras.json has");
  std::vector<Camera> cameras;
  cameras.reserve(root.size());
  const std::vector<std::uint64_t> offsets = offsets_in(source.text(), source.text().find('['));
  for (std::size_t i = 0; i < root.size(); ++i)
    cameras.push_back(camera_of(JsonEntry(source, root[i], offsets[i], "a camera")));
  return cameras;
}

}  // namespace swiftgs::io
