// SPDX-License-Identifier: Apache-2.0
#include "scene_encoding.hpp"

#include "scene_building.hpp"

namespace swiftgs::io {

void keep_renderable(const Scene& scene, std::vector<std::uint32_t>& order, std::vector<std::string>& notes) {
  const std::size_t left_out = std::erase_if(order, [&](std::uint32_t i) { return !renderable(scene, i); });
  if (left_out != 0)
    notes.push_back("Gaussians with a NaN or an infinity are left out: " + std::to_string(left_out) + ".");
}

void ClampCount::note(const std::string& things, const std::string& range,
                      std::vector<std::string>& notes) const {
  if (count_ != 0) notes.push_back(things + " are clamped to " + range + ": " + std::to_string(count_) + ".");
}

}  // namespace swiftgs::io
