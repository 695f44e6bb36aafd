// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/clip.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/message.hpp>
#include <swiftgs/similarity.hpp>
#include <swiftgs/tint.hpp>

namespace swiftgs::detail {

/// Says what was expected, or is null if a frame can show a scene like this.
SWIFTGS_HD inline const char* unmet_of_placing(const Similarity& world_from_scene, float opacity,
                                               const Clip& clip, const Tint& tint) {
  if (const char* const expected = world_from_scene.unmet()) return expected;
  if (!(opacity >= 0 && opacity <= 1)) return "an opacity of 0 to 1";
  if (const char* const expected = clip.unmet()) return expected;
  return tint.unmet();
}

/// Throws `InvalidArgument` unless a frame can show a scene like this.
inline void validate_placing(const Similarity& world_from_scene, float opacity, const Clip& clip,
                             const Tint& tint) {
  if (const char* const expected = unmet_of_placing(world_from_scene, opacity, clip, tint))
    refuse("placed scene: expected ", expected);
}

}  // namespace swiftgs::detail
