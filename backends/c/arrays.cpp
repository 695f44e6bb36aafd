// SPDX-License-Identifier: Apache-2.0

// Scenes from arrays of the caller.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <scene_building.hpp>

#include "device.hpp"
#include "error.hpp"
#include "scene.hpp"
#include "structs.hpp"

namespace swiftgs::c {
namespace {

/// Copies `count` times `width` floats of a caller's array, each `width` of them `stride` bytes after those
/// before.
class Gather {
 public:
  explicit Gather(const swiftgs_gaussians& from) : from_(from) {}

  template <class T>
  void operator()(const char* name, const swiftgs_array& array, std::size_t width, std::vector<T>& to) {
    const auto count = std::size_t(from_.count);
    to.resize(count * width * sizeof(float) / sizeof(T));
    if (to.empty()) return;
    const std::size_t row = width * sizeof(float), stride = checked_stride(name, array, row);
    const auto* bytes = reinterpret_cast<const unsigned char*>(array.data);
    if (from_.memory == SWIFTGS_DEVICE) {
      fetched_.resize((count - 1) * stride + row);
      copy_from_device(array.data, fetched_.size(), from_.stream, fetched_.data());
      bytes = fetched_.data();
    }
    auto* const floats = reinterpret_cast<unsigned char*>(to.data());
    if (stride == row)
      std::memcpy(floats, bytes, count * row);
    else
      for (std::size_t i = 0; i < count; ++i) std::memcpy(floats + i * row, bytes + i * stride, row);
  }

 private:
  std::size_t checked_stride(const char* name, const swiftgs_array& array, std::size_t row) const {
    const std::string what = std::string("swiftgs_gaussians: ") + name;
    require_pointer(array.data, what.c_str());
    if (array.stride == 0) return row;
    const auto most = std::uint64_t(std::numeric_limits<std::ptrdiff_t>::max()) / from_.count;
    if (array.stride < std::int64_t(row) || array.stride % std::int64_t(sizeof(float)) != 0 ||
        std::uint64_t(array.stride) > most)
      throw std::invalid_argument(what + ": stride is " + std::to_string(array.stride) +
                                  " bytes, expected 0 or a multiple of 4 from " + std::to_string(row) +
                                  " to " + std::to_string(most));
    return std::size_t(array.stride);
  }

  const swiftgs_gaussians& from_;
  std::vector<unsigned char> fetched_;
};

/// Does to the numbers what readers do to those of files.
void activate(Scene& scene, std::uint32_t raw) {
  if (raw & SWIFTGS_LOG_SCALES)
    for (vec3& scale : scene.scales) scale = {std::exp(scale.x), std::exp(scale.y), std::exp(scale.z)};
  if (raw & SWIFTGS_LOGIT_OPACITIES)
    for (float& opacity : scene.opacities) opacity = io::sigmoid(opacity);
  if (raw & SWIFTGS_ANY_ROTATIONS)
    for (Quaternion& q : scene.rotations) q = io::normalised(q.w, q.x, q.y, q.z);
}

}  // namespace

void check_count(std::uint64_t count) {
  if (count > std::numeric_limits<std::uint32_t>::max())
    throw std::invalid_argument("scene: " + std::to_string(count) + " Gaussians, expected fewer than 2^32");
}

Scene to_scene(const swiftgs_gaussians* given) {
  const swiftgs_gaussians from = read_struct(given, "swiftgs_gaussians");
  require_zero(from.reserved, "swiftgs_gaussians");
  require_choice(from.memory, 2, "swiftgs_gaussians: memory");
  require_choice(from.sh_degree, max_sh_degree + 1, "swiftgs_gaussians: sh_degree");
  constexpr std::uint32_t known = SWIFTGS_LOG_SCALES | SWIFTGS_LOGIT_OPACITIES | SWIFTGS_ANY_ROTATIONS;
  if (from.raw & ~known)
    throw std::invalid_argument("swiftgs_gaussians: raw is " + std::to_string(from.raw) +
                                ", expected a sum of 1, 2 and 4");
  check_count(from.count);
  if (from.memory == SWIFTGS_DEVICE) require_device();

  Scene scene;
  scene.sh_degree = from.sh_degree;
  scene.antialiased = from.antialiased != 0;
  Gather gather(from);
  gather("means", from.means, 3, scene.means);
  gather("scales", from.scales, 3, scene.scales);
  gather("rotations", from.rotations, 4, scene.rotations);
  gather("opacities", from.opacities, 1, scene.opacities);
  gather("sh0", from.sh0, 3, scene.sh0);
  gather("sh_rest", from.sh_rest, 3 * std::size_t(sh_rest_count(from.sh_degree)), scene.sh_rest);
  activate(scene, from.raw);
  return scene;
}

}  // namespace swiftgs::c
