// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/placing.hpp>

#include "scene_list.hpp"

/// Any bytes are scenes that can be placed, or a `FormatError`.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  try {
    for (const swiftgs::ListedScene& scene : swiftgs::io::parse_scene_list({bytes, "fuzz"})) {
      swiftgs::validate(scene.world_from_scene);
      if (scene.file.empty() || !(scene.opacity >= 0 && scene.opacity <= 1) || scene.tint.unmet() ||
          scene.count == 0 || scene.half_spaces.size() > std::size_t(swiftgs::Clip::max_half_spaces))
        std::abort();
      for (const swiftgs::HalfSpace& half : scene.half_spaces) swiftgs::validate(half);
      if (scene.sphere) swiftgs::validate(*scene.sphere);
    }
  } catch (const swiftgs::FormatError&) {
  }
  return 0;
}
