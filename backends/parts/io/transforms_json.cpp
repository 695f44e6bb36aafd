// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>
#include <string>

#include <glm/matrix.hpp>

#include <swiftgs/error.hpp>

#include "camera_parsing.hpp"
#include "image_parsing.hpp"
#include "mapped_file.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

/// What a frame or the object around it is asked for, and what no picture shows: where a trainer finds masks,
/// depths and points, how it splits the images, and its own box. EUCM's `beta` shows in none while `alpha` is
/// 0.
constexpr std::string_view file_keys[] = {"frames",
                                          "file_path",
                                          "transform_matrix",
                                          "w",
                                          "h",
                                          "fl_x",
                                          "fl_y",
                                          "cx",
                                          "cy",
                                          "x_fov",
                                          "y_fov",
                                          "camera_angle_x",
                                          "camera_angle_y",
                                          "applied_transform",
                                          "applied_scale",
                                          "aabb_scale",
                                          "beta",
                                          "colmap_im_id",
                                          "depth_file_path",
                                          "depth_path",
                                          "enable_depth_loading",
                                          "fisheye_crop_radius",
                                          "integer_depth_scale",
                                          "mask_path",
                                          "orientation_override",
                                          "ply_file_path",
                                          "rotation",
                                          "sharpness",
                                          "test_filenames",
                                          "timestamp",
                                          "train_filenames",
                                          "val_filenames"};

/// Sets the size from the file, or else from the header of the frame's image in `folder`.
void set_size(Camera& camera, const CameraEntry& frame, const std::filesystem::path& folder) {
  const JsonEntry *width = frame.with("w"), *height = frame.with("h");
  if (width && height) {
    camera.width = to_side(width->source(), width->offset(), width->number("w"));
    camera.height = to_side(height->source(), height->offset(), height->number("h"));
    return;
  }
  if (folder.empty()) frame.own.fail("a frame with 'w' and 'h', or a file with its images beside it");
  std::filesystem::path image = folder / frame.own.string("file_path");
  if (std::filesystem::path png = image; !exists(image) && exists(png += ".png")) image = png;
  try {
    const MappedFile file(image);
    const ImageSize size = image_size({file.bytes(), image.string()});
    camera.width = size.width, camera.height = size.height;
  } catch (const FileError& error) {
    frame.own.fail(std::string("a frame with 'w' and 'h', or its image (") + error.what() + ")");
  }
}

/// Where a focal length is stored: as pixels, or as an angle of view in degrees or radians.
struct FocalKeys {
  const char *pixels, *degrees, *radians;
};

/// The focal length along an image side; 0 if there is none. An orthographic lens has no angle of view.
double focal_length(const CameraEntry& frame, const FocalKeys& keys, int side, bool has_angles) {
  for (const JsonEntry* entry : {&frame.own, &frame.shared}) {
    if (entry->has(keys.pixels)) return entry->number(keys.pixels);
    if (!has_angles) continue;
    if (entry->has(keys.degrees)) return length_of_angle(*entry, keys.degrees, std::numbers::pi / 180, side);
    if (entry->has(keys.radians)) return length_of_angle(*entry, keys.radians, 1, side);
  }
  return 0;
}

void set_intrinsics(Camera& camera, const CameraEntry& frame) {
  const bool has_angles = !traits_of(camera.lens.model).parallel_rays;
  camera.fx = focal_length(frame, {"fl_x", "x_fov", "camera_angle_x"}, camera.width, has_angles);
  camera.fy = focal_length(frame, {"fl_y", "y_fov", "camera_angle_y"}, camera.height, has_angles);
  if (camera.fx == 0) camera.fx = camera.fy;
  if (camera.fx == 0)
    frame.own.fail(has_angles ? "a focal length above 0 in 'fl_x', 'fl_y', 'x_fov', 'y_fov', "
                                "'camera_angle_x' or 'camera_angle_y'"
                              : "a focal length above 0 in 'fl_x' or 'fl_y' of an orthographic lens");
  if (camera.fy == 0) camera.fy = camera.fx;
  const JsonEntry *cx = frame.with("cx"), *cy = frame.with("cy");
  camera.cx = cx ? cx->number("cx") : 0.5 * camera.width;
  camera.cy = cy ? cy->number("cy") : 0.5 * camera.height;
}

/// Adds the keys by which nerfstudio would show another part of the sphere than all of it. instant-ngp's lens
/// has no such keys.
void add_unlike_sphere(UnreadKeys& unread, const CameraEntry& frame, const Camera& camera) {
  if (!traits_of(camera.lens.model).shows_sphere || !frame.with("camera_model")) return;
  const auto expect = [&](const char* key, double pixels) {
    if (const JsonEntry* with = frame.with(key); with && !(std::abs(with->number(key) - pixels) <= 1))
      unread.add(key);
  };
  expect("fl_x", 0.5 * camera.width), expect("fl_y", camera.height);
  expect("cx", 0.5 * camera.width), expect("cy", 0.5 * camera.height);
}

/// p -> scale (rotation p + translation), from the file's world to that of the model.
struct WorldChange {
  dmat3 rotation{1.0};
  dvec3 translation{0.0};
  double scale = 1;
};

Affine rigid(const JsonEntry& entry, const char* key) {
  const Affine affine = entry.affine(key);
  const dmat3 product = glm::transpose(affine.linear) * affine.linear;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(product[i][j] - (i == j)) < 1e-3))
        entry.fail(std::string("a rotation and a translation in '") + key + "'");
  return affine;
}

double scale_in(const JsonEntry& entry, const char* key) {
  const double scale = entry.number(key);
  if (!(scale > 0)) entry.fail(std::string("a scale above 0 in '") + key + "'");
  return scale;
}

/// nerfstudio's `dataparser_transforms.json` starts at the world before `root` applied what it says.
WorldChange world_change(const JsonEntry& root, const Source& dataparser) {
  const json value = parse_json(dataparser);
  const JsonEntry entry(dataparser, value, 0, "nerfstudio's dataparser_transforms.json");
  const auto [transform, offset] = rigid(entry, "transform");
  WorldChange change{transform, offset, scale_in(entry, "scale")};
  if (root.has("applied_transform")) {
    const auto [applied, applied_offset] = rigid(root, "applied_transform");
    change.rotation = transform * glm::inverse(applied);
    change.translation = offset - change.rotation * applied_offset;
  }
  if (root.has("applied_scale")) change.scale /= scale_in(root, "applied_scale");
  return change;
}

Camera camera_of(const CameraEntry& frame, const std::filesystem::path& folder, const WorldChange& change) {
  Camera camera;
  camera.lens = lens_of(frame);
  if (frame.own.has("file_path")) camera.name = frame.own.string("file_path");
  const auto [axes, centre] = frame.own.affine("transform_matrix");
  set_opengl_pose(camera, change.rotation * axes,
                  change.scale * (change.rotation * centre + change.translation));
  set_size(camera, frame, folder);
  if (traits_of(camera.lens.model).shows_sphere)
    show_sphere(camera, camera.width, camera.height);
  else
    set_intrinsics(camera, frame);  // those of an orthographic lens are of the model's world, as nerfstudio's
  expect_valid(frame.own.source(), frame.own.offset(), camera);
  return camera;
}

}  // namespace

CameraFile parse_transforms_json(const Source& source, const std::filesystem::path& folder,
                                 const Source* dataparser) {
  const json value = parse_json(source);
  const JsonEntry root(source, value, 0, "a transforms.json");
  const json& frames = root.member("frames");
  if (!frames.is_array()) root.fail("'frames' to be an array");
  const WorldChange change = dataparser ? world_change(root, *dataparser) : WorldChange{};
  const std::string_view text = source.text();
  const std::vector<std::uint64_t> offsets =
      offsets_in(text, offset_of_member(text, text.find('{'), "frames"));
  CameraFile file;
  UnreadKeys unread(file_keys);
  unread.add(root);
  file.cameras.reserve(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const CameraEntry frame{JsonEntry(source, frames[i], offsets[i], "a frame"), root};
    file.cameras.push_back(camera_of(frame, folder, change));
    unread.add(frame.own);
    add_unlike_sphere(unread, frame, file.cameras.back());
  }
  if (!dataparser && (root.has("applied_transform") || root.has("applied_scale")))
    file.notes.push_back(
        "The cameras stay in the world of the file; for a scene that nerfstudio exported, put its "
        "dataparser_transforms.json beside the file.");
  unread.note(file.notes);
  return file;
}

CameraFile read_transforms_json(const Source& source, const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "dataparser_transforms.json";
  if (!std::filesystem::exists(path)) return parse_transforms_json(source, folder);
  const MappedFile file(path);
  const Source dataparser{file.bytes(), path.string()};
  return parse_transforms_json(source, folder, &dataparser);
}

}  // namespace swiftgs::io
