// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>

#include "camera_parsing.hpp"
#include "colmap_models.hpp"

namespace swiftgs::io {
namespace {

ColmapIntrinsics parse_cameras(const Source& source) {
  ByteReader reader(source);
  const auto count = reader.read<std::uint64_t>("the number of cameras");
  constexpr std::uint64_t least_bytes = 4 + 4 + 8 + 8 + 3 * 8;
  reader.expect(count, least_bytes, "cameras");
  ColmapIntrinsics intrinsics;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t start = reader.position();
    const auto id = reader.read<std::uint32_t>("a camera id");
    const std::uint64_t model_start = reader.position();
    const ColmapModel model = colmap_model(source, model_start, reader.read<std::int32_t>("a camera model"));
    Camera camera;
    camera.width = to_side(source, start, double(reader.read<std::uint64_t>("a width")));
    camera.height = to_side(source, start, double(reader.read<std::uint64_t>("a height")));
    std::array<double, 4> parameters{};
    for (int p = 0; p < model.parameters; ++p) parameters[p] = reader.read<double>("a camera parameter");
    set_intrinsics(camera, parameters.data(), model.parameters);
    if (!intrinsics.emplace(id, camera).second)
      source.fail(start, "each camera id once, found " + std::to_string(id) + " again");
  }
  reader.expect_end("the last camera");
  return intrinsics;
}

}  // namespace

std::vector<Camera> parse_colmap_binary(const Source& cameras, const Source& images) {
  const ColmapIntrinsics intrinsics = parse_cameras(cameras);
  ByteReader reader(images);
  const auto count = reader.read<std::uint64_t>("the number of images");
  constexpr std::uint64_t least_bytes = 4 + 7 * 8 + 4 + 1 + 8, point_bytes = 24;
  reader.expect(count, least_bytes, "images");
  std::vector<Camera> result;
  result.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t start = reader.position();
    reader.read<std::uint32_t>("an image id");
    std::array<double, 7> numbers;
    for (double& number : numbers) number = reader.read<double>("a pose");
    const auto [w, x, y, z, tx, ty, tz] = numbers;
    const auto camera_id = reader.read<std::uint32_t>("a camera id");
    const std::string_view name = reader.c_string("an image name");
    const auto points = reader.read<std::uint64_t>("the number of points");
    reader.expect(points, point_bytes, "points");
    reader.take(points * point_bytes, "points");
    result.push_back(place(images, start, intrinsics, {w, x, y, z, dvec3(tx, ty, tz), camera_id}, name));
  }
  reader.expect_end("the last image");
  return result;
}

}  // namespace swiftgs::io
