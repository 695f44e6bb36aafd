// SPDX-License-Identifier: Apache-2.0
#include "view/camera_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <exception>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <nlohmann/json.hpp>

#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/edit/transform.hpp>
#include <swiftgs/io/cameras.hpp>
#include <swiftgs/io/replace_file.hpp>

namespace swiftgs::cli {
namespace {

using nlohmann::json;

/// What a path interpolates: centre, rotation as a quaternion, and the logarithm of half the image's height
/// over the focal length.
using Key = std::array<double, 8>;

Key key_of(const Camera& camera) {
  const dvec3 at = camera.centre();
  const DQuaternion q = quaternion_of(camera.rotation);
  return {at.x, at.y, at.z, q.w, q.x, q.y, q.z, std::log(0.5 * camera.height / camera.fy)};
}

/// `next`, whose rotation has two quaternions, by the one that is nearer to that of `key`.
Key near_to(const Key& key, Key next) {
  const double product = key[3] * next[3] + key[4] * next[4] + key[5] * next[5] + key[6] * next[6];
  for (std::size_t i = 3; product < 0 && i < 7; ++i) next[i] = -next[i];
  return next;
}

/// A Catmull-Rom spline from `b` to `c`.
double spline(double a, double b, double c, double d, double t) {
  return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)));
}

double vertical_degrees(const Camera& camera) {
  return 2 * std::atan(0.5 * camera.height / camera.fy) * 180 / std::numbers::pi;
}

/// 16 numbers by rows, from the camera to the world, with OpenGL's axes.
json pose_of(const Camera& camera, const dvec3& origin) {
  const dvec3 centre = camera.centre() + origin;
  json numbers = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis) numbers.push_back((axis == 0 ? 1 : -1) * camera.rotation[row][axis]);
    numbers.push_back(centre[row]);
  }
  for (const double number : {0.0, 0.0, 0.0, 1.0}) numbers.push_back(number);
  return numbers;
}

/// What nerfstudio's viewer asks of every camera.
json entry_of(const Camera& camera, const char* pose, const dvec3& origin) {
  return {{pose, pose_of(camera, origin)},
          {"fov", vertical_degrees(camera)},
          {"aspect", double(camera.width) / camera.height}};
}

/// The camera of an object that `entry_of` wrote; `like` has the size of its image. Throws json::exception.
Camera camera_of(const json& key, const Camera& like) {
  const auto numbers = key.at("matrix").get<std::array<double, 16>>();
  Camera camera = like;
  dvec3 centre;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      camera.rotation[int(row)][int(axis)] = (axis == 0 ? 1 : -1) * numbers[4 * row + axis];
    centre[int(row)] = numbers[4 * row + 3];
  }
  camera.translation = -(camera.rotation * centre);
  camera.fy = 0.5 * camera.height / std::tan(0.5 * key.at("fov").get<double>() * std::numbers::pi / 180);
  camera.fx = camera.fy;
  validate(camera);
  return camera;
}

/// Takes the keys of `root` in place of the frames that are made of them, if their times are those of a path
/// here. Throws as `camera_of`.
void take_keys(const json& root, CameraPath& path) {
  const json& keys = root.at("keyframes");
  const double seconds_a_key = root.at("default_transition_sec").get<double>();
  const double seconds = seconds_a_key * (double(keys.size()) - 1);
  if (keys.empty() || !(seconds_a_key > 0 && std::abs(root.at("seconds").get<double>() - seconds) < 1e-6))
    return;
  std::vector<Camera> cameras;
  for (const json& key : keys) cameras.push_back(camera_of(key, path.keys[0]));
  path.keys = std::move(cameras), path.seconds_a_key = seconds_a_key;
}

}  // namespace

Camera camera_at(const CameraPath& path, double seconds, int width, int height) {
  const double last = double(path.keys.size() - 1);
  const double at = std::clamp(seconds / path.seconds_a_key, 0.0, last);
  const double first = std::clamp(std::floor(at), 0.0, std::max(0.0, last - 1));
  const auto key = [&](double i) { return key_of(path.keys[std::size_t(std::clamp(i, 0.0, last))]); };
  const Key a = key(first - 1), b = near_to(a, key(first)), c = near_to(b, key(first + 1)),
            d = near_to(c, key(first + 2));
  Key now{};
  for (std::size_t i = 0; i < now.size(); ++i) now[i] = spline(a[i], b[i], c[i], d[i], at - first);

  Camera camera;
  camera.width = width, camera.height = height, camera.cx = 0.5 * width, camera.cy = 0.5 * height;
  camera.fx = camera.fy = 0.5 * height / std::exp(now[7]);
  camera.rotation = matrix_of(unit({now[3], now[4], now[5], now[6]}));
  camera.translation = -(camera.rotation * dvec3(now[0], now[1], now[2]));
  return camera;
}

void write_camera_path(const std::filesystem::path& file, const CameraPath& path, int width, int height,
                       const dvec3& origin) {
  json keys = json::array(), frames = json::array();
  for (const Camera& key : path.keys) keys.push_back(entry_of(key, "matrix", origin));
  const double last = std::floor(path.seconds() * path.frames_a_second + 1e-9);
  for (double frame = 0; frame <= last; ++frame)
    frames.push_back(
        entry_of(camera_at(path, frame / path.frames_a_second, width, height), "camera_to_world", origin));
  const json root{{"camera_type", "perspective"},
                  {"render_width", width},
                  {"render_height", height},
                  {"fps", path.frames_a_second},
                  {"seconds", path.seconds()},
                  {"default_fov", vertical_degrees(path.keys[0])},
                  {"default_transition_sec", path.seconds_a_key},
                  {"is_cycle", false},
                  {"smoothness_value", 0},
                  {"keyframes", std::move(keys)},
                  {"camera_path", std::move(frames)}};
  replace_file(file, root.dump(1) + '\n');
}

bool is_camera_path(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (file.extension() != ".json" || !stream) return false;
  const json root = json::parse(stream, nullptr, false);
  return root.is_object() && root.contains("camera_path");
}

CameraPath read_camera_path(const std::filesystem::path& file, const dvec3& origin) {
  CameraFile read = read_cameras(file);
  if (read.cameras.empty())
    throw std::invalid_argument(file.string() + ": expected at least one camera, found none");
  CameraPath path;
  path.keys = std::move(read.cameras);
  if (read.frames_a_second > 0) path.frames_a_second = read.frames_a_second;
  path.seconds_a_key = 1 / path.frames_a_second;
  try {
    std::ifstream stream(file);
    take_keys(json::parse(stream), path);
  } catch (const std::exception&) {
    // Older viewers had other keys, and other files have none: the frames say all.
  }
  for (Camera& key : path.keys) key = transformed(key, {.translation = -origin});
  return path;
}

}  // namespace swiftgs::cli
