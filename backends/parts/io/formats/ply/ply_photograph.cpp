// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <optional>

#include <swiftgs/error.hpp>

#include "ply_fields.hpp"
#include "ply_header.hpp"
#include "scene_building.hpp"

namespace swiftgs::io {
namespace {

/// The elements beside the vertices, by name.
struct Elements {
  const Source& source;
  const PlyHeader& header;
  const std::map<std::string, std::uint64_t>& starts;

  /// The numbers of an element with one property that has its name; none where it has another form.
  std::vector<double> numbers(const char* name) const {
    constexpr std::uint64_t most = 16;
    const PlyElement* element = header.find(name);
    if (!element || element->count > most || element->properties.size() != 1 ||
        element->properties[0].name != name || element->has_lists())
      return {};
    std::vector<double> values, row;
    std::uint64_t position = starts.at(name);
    const PlyType type = element->properties[0].type;
    const auto order = header.encoding == PlyEncoding::big_endian ? std::endian::big : std::endian::little;
    for (std::uint64_t i = 0; i < element->count; ++i) {
      if (header.encoding == PlyEncoding::ascii) {
        position = parse_text_row(source, *element, position, row);
        values.push_back(row[0]);
      } else {
        values.push_back(scalar_at(source.bytes.data() + position, {type, 0}, order));
        position += size_of(type);
      }
    }
    return values;
  }
};

int pixels(double value) { return value >= 1 && value <= max_image_side ? int(value) : 0; }

/// World to camera: a 4x4 matrix by rows, or 3x4 with a transposed rotation as early versions wrote it.
void set_pose(const std::vector<double>& extrinsic, Camera& camera) {
  const bool early = extrinsic.size() == 12;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      (early ? camera.rotation[int(row)][int(column)] : camera.rotation[int(column)][int(row)]) =
          extrinsic[4 * row + column];
    camera.translation[int(row)] = extrinsic[4 * row + 3];
  }
}

std::optional<Camera> camera_of(const Elements& elements) {
  const std::vector<double> extrinsic = elements.numbers("extrinsic"), k = elements.numbers("intrinsic"),
                            size = elements.numbers("image_size");
  Camera camera;
  if (extrinsic.size() != 16 && extrinsic.size() != 12) return std::nullopt;
  set_pose(extrinsic, camera);
  if (k.size() == 9 && size.size() == 2) {
    camera.fx = k[0], camera.fy = k[4], camera.cx = k[2], camera.cy = k[5];
    camera.width = pixels(size[0]), camera.height = pixels(size[1]);
  } else if (k.size() == 4) {  // early versions: focal lengths and the size
    camera.fx = k[0], camera.fy = k[1], camera.cx = k[2] / 2, camera.cy = k[3] / 2;
    camera.width = pixels(k[2]), camera.height = pixels(k[3]);
  }
  try {
    validate(camera);
  } catch (const InvalidArgument&) {
    return std::nullopt;
  }
  return camera;
}

double srgb_of(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

void make_srgb(std::vector<vec3>& colours) {
  for (vec3& sh0 : colours)
    for (int c = 0; c < 3; ++c) sh0[c] = float((srgb_of(0.5 + sh_c0 * double(sh0[c])) - 0.5) / sh_c0);
}

}  // namespace

void read_photograph(const Source& source, const PlyHeader& header,
                     const std::map<std::string, std::uint64_t>& starts, SceneFile& file,
                     std::vector<std::string_view>& read) {
  const Elements elements{source, header, starts};
  if (const std::vector<double> space = elements.numbers("color_space"); !space.empty()) {
    read.emplace_back("color_space");
    if (space[0] != 0) {
      make_srgb(file.scene.sh0);
      file.notes.push_back("The colours are linear (color_space) and become sRGB.");
    }
  }
  file.camera = camera_of(elements);
  if (!file.camera) return;
  file.notes.push_back("The file holds the camera of its photograph, of " +
                       std::to_string(file.camera->width) + "x" + std::to_string(file.camera->height) +
                       " pixels.");
  // The last three tell of the training, and change no frame.
  for (const char* name : {"extrinsic", "intrinsic", "image_size", "frame", "disparity", "version"})
    read.emplace_back(name);
}

}  // namespace swiftgs::io
