// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include <swiftgs/edit/transform.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/scene.hpp>

#include "policies/random_splats.hpp"

namespace swiftgs::test {

/// A placed scene, on the host.
struct Placed {
  Scene scene;
  Similarity pose{};
  float opacity = 1;
  Clip clip{};
  Tint tint{};
};
using List = std::vector<Placed>;

inline std::vector<ReferenceScene> for_reference(const List& list) {
  std::vector<ReferenceScene> out;
  for (const Placed& p : list) out.push_back({p.scene, p.pose, p.opacity, p.clip, p.tint});
  return out;
}

inline Similarity pose_of(Random& random, double scale, dvec3 to) {
  const Quaternion q = random_rotation(random);
  return {matrix_of(swiftgs::unit(DQuaternion{q.w, q.x, q.y, q.z})), scale, to};
}

/// A movement about no axis of the world.
inline Similarity moved(double scale = 1, dvec3 to = dvec3(0.3, -0.2, 0.7)) {
  return {matrix_of(swiftgs::unit(DQuaternion{0.8, 0.3, -0.4, 0.2})), scale, to};
}

/// `scene` in a space of its own, from which `pose` brings it back to where it was.
inline Placed placed_by(Scene scene, const Similarity& pose, float opacity = 1, const Clip& clip = {}) {
  transform(scene, inverse(pose), dvec3(0.0));
  return {std::move(scene), pose, opacity, clip};
}

/// A list where backend `B` reads it.
template <class B>
struct ListOn {
  ListOn(const B& backend, const List& list) {
    for (const Placed& p : list) {
      uploaded.push_back(backend.upload(p.scene));
      placed.push_back({uploaded.back().view(), p.pose, p.opacity, p.clip, p.tint});
    }
  }

  std::vector<typename B::SceneOn> uploaded;
  std::vector<PlacedScene> placed;
};

}  // namespace swiftgs::test
