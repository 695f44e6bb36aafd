// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/clip.hpp>
#include <swiftgs/placing.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/similarity.hpp>
#include <swiftgs/tint.hpp>

namespace swiftgs {

/// A placed scene of the reference: as `PlacedScene`, of a scene on the host, which must outlive it.
struct ReferenceScene {
  const Scene& scene;
  Similarity world_from_scene{};
  float opacity = 1;
  Clip clip{};
  Tint tint{};
};

/// Throws `InvalidArgument` as `validate` of a `PlacedScene`.
inline void validate(const ReferenceScene& placed) {
  validate(placed.scene);
  detail::validate_placing(placed.world_from_scene, placed.opacity, placed.clip, placed.tint);
}

}  // namespace swiftgs
