// SPDX-License-Identifier: Apache-2.0
#include "scene_encoding.hpp"

#include "parallel.hpp"
#include "scene_building.hpp"

namespace swiftgs::io {

void keep_renderable(const Scene& scene, std::vector<std::uint32_t>& order, std::vector<std::string>& notes) {
  // Memory is read in its own order, which is much quicker than in a spatial one.
  std::vector<std::uint8_t> kept(scene.size());
  for_parts(scene.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) kept[i] = renderable(scene, i);
  });
  const std::size_t left_out = std::erase_if(order, [&](std::uint32_t i) { return !kept[i]; });
  if (left_out != 0)
    notes.push_back("Gaussians with a NaN or an infinity are left out: " + std::to_string(left_out) + ".");
}

void ClampCount::note(const std::string& things, const std::string& range,
                      std::vector<std::string>& notes) const {
  if (count_ != 0) notes.push_back(things + " are clamped to " + range + ": " + std::to_string(count_) + ".");
}

}  // namespace swiftgs::io
