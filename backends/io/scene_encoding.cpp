// SPDX-License-Identifier: Apache-2.0
#include "scene_encoding.hpp"

#include <algorithm>

#include "parallel.hpp"
#include "scene_building.hpp"

namespace swiftgs::io {
namespace {

bool has_negative_scale(const Scene& scene, std::size_t i) {
  const vec3& scale = scene.scales[i];
  return scale.x < 0 || scale.y < 0 || scale.z < 0;
}

}  // namespace

std::optional<Scene> encodable(const Scene& scene, std::vector<std::string>& notes) {
  std::vector<Fault> faults(scene.size());
  std::atomic<std::uint64_t> invalid = 0, opacities = 0, negative = 0;
  for_parts(scene.size(), [&](std::size_t begin, std::size_t end) {
    std::uint64_t own_invalid = 0, own_opacities = 0, own_negative = 0;
    for (std::size_t i = begin; i < end; ++i) {
      faults[i] = fault_of(scene, i);
      own_invalid += faults[i] != Fault::none;
      if (faults[i] != Fault::none) continue;
      own_opacities += scene.opacities[i] < 0 || scene.opacities[i] > 1;
      own_negative += has_negative_scale(scene, i);
    }
    invalid += own_invalid, opacities += own_opacities, negative += own_negative;
  });
  if (invalid + opacities + negative == 0) return std::nullopt;

  Scene result = scene;
  note_left_out(leave_out(result, faults), notes);
  note_clamped(opacities, "Opacities", "0 to 1", notes);
  if (negative != 0)
    notes.push_back(
        "Scales below 0 are written without their sign, of Gaussians: " + std::to_string(negative) + ".");
  for (float& opacity : result.opacities) opacity = std::clamp(opacity, 0.0f, 1.0f);
  for (vec3& scale : result.scales) scale = glm::abs(scale);
  return result;
}

WrittenScene written_whole(std::string format, const Scene& scene) {
  return {.format = std::move(format),
          .gaussians = scene.size(),
          .sh_degree = scene.sh_degree,
          .model = scene.model};
}

void note_clamped(std::uint64_t count, const std::string& things, const std::string& range,
                  std::vector<std::string>& notes) {
  if (count != 0) notes.push_back(things + " are clamped to " + range + ": " + std::to_string(count) + ".");
}

}  // namespace swiftgs::io
