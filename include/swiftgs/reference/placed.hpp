// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

#include <swiftgs/clip.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/similarity.hpp>

namespace swiftgs {

/// A placed scene of the reference: as `PlacedScene`, of a scene on the host, which must outlive it.
struct ReferenceScene {
  const Scene& scene;
  Similarity world_from_scene{};
  float opacity = 1;
  Clip clip{};
};

/// Throws `std::invalid_argument` as `validate` of a `PlacedScene`.
inline void validate(const ReferenceScene& placed) {
  validate(placed.scene);
  validate(placed.world_from_scene, "placed scene");
  if (!(placed.opacity >= 0 && placed.opacity <= 1))
    throw std::invalid_argument("placed scene: expected an opacity of 0 to 1");
  validate(placed.clip);
}

}  // namespace swiftgs
