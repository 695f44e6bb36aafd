// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>

#include "camera_parsing.hpp"
#include "colmap_models.hpp"

namespace swiftgs::io {
namespace {

/// What a camera's record begins with.
struct Head {
  std::uint32_t id;
  const ColmapModel* model;
};

/// Throws `FormatError` for a model that is not known: nobody can tell where its record ends.
Head read_head(const Source& source, ByteReader& reader) {
  const auto id = reader.read<std::uint32_t>("a camera id");
  const std::uint64_t start = reader.position();
  const auto number = reader.read<std::int32_t>("a camera model");
  const ColmapModel* model = colmap_model(number);
  if (!model) refuse_model(source, start, "number " + std::to_string(number));
  return {id, model};
}

Camera camera_at(const Source& source, std::uint64_t offset) {
  ByteReader reader(source, offset);
  const ColmapModel& model = *read_head(source, reader).model;
  Camera camera;
  camera.width = to_side(source, offset, double(reader.read<std::uint64_t>("a width")));
  camera.height = to_side(source, offset, double(reader.read<std::uint64_t>("a height")));
  std::array<double, ColmapModel::most_parameters> parameters{};
  for (int p = 0; p < model.parameters; ++p) parameters[p] = reader.read<double>("a camera parameter");
  set_intrinsics(camera, model, parameters, source, offset);
  return camera;
}

ColmapCameras find_cameras(const Source& source) {
  ColmapCameras cameras(source, camera_at);
  ByteReader reader(source);
  const auto count = reader.read<std::uint64_t>("the number of cameras");
  constexpr std::uint64_t least_bytes = 4 + 4 + 8 + 8 + 2 * 8;
  reader.expect(count, least_bytes, "cameras");
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t start = reader.position();
    const Head head = read_head(source, reader);
    reader.take(std::uint64_t(8 + 8 + 8 * head.model->parameters), "a camera's size and parameters");
    cameras.add(head.id, start);
  }
  reader.expect_end("the last camera");
  return cameras;
}

}  // namespace

std::vector<Camera> parse_colmap_binary(const Source& cameras, const Source& images) {
  const ColmapCameras known = find_cameras(cameras);
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
    result.push_back(known.place(images, start, {w, x, y, z, dvec3(tx, ty, tz), camera_id}, name));
  }
  reader.expect_end("the last image");
  return result;
}

}  // namespace swiftgs::io
