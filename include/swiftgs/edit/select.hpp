// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include <swiftgs/edit/origin.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// The Gaussians `kept` of `scene`, in that order; @shape{any number}. Linear in their number. Throws
/// `InvalidArgument` as `validate` does, and if an index in `kept` is not below the number of
/// Gaussians.
inline Scene subset(const Scene& scene, const std::vector<std::uint32_t>& kept) {
  validate(scene);
  for (const std::uint32_t i : kept)
    if (i >= scene.size()) detail::refuse("subset: expected Gaussians below ", scene.size(), ", got ", i);
  Scene out = empty_like(scene);
  for_each_array(
      [&](const char*, std::size_t each, const auto& from, auto& to) {
        to.reserve(each * kept.size());
        for (const std::uint32_t i : kept) {
          const auto first = from.begin() + std::ptrdiff_t(each * i);
          to.insert(to.end(), first, first + std::ptrdiff_t(each));
        }
      },
      scene, out);
  return out;
}

/// Indices of the Gaussians for which `keep(i)` is true, ascending; @shape{any number}. Asks once for each.
/// Throws `InvalidArgument` as `validate` does, and `CapacityError` beyond 2^32 - 1 Gaussians.
template <class Predicate>
std::vector<std::uint32_t> select(const Scene& scene, Predicate&& keep) {
  validate(scene);
  const std::size_t most = std::numeric_limits<std::uint32_t>::max();
  if (scene.size() > most) throw CapacityError("Gaussians", scene.size(), most);
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < scene.size(); ++i)
    if (keep(i)) kept.push_back(std::uint32_t(i));
  return kept;
}

/// Positions between two corners, both included.
struct Box {
  dvec3 low{0.0}, high{0.0};

  bool contains(const dvec3& p) const {
    return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z && p.z <= high.z;
  }
};

/// Positions at most `radius` from the centre.
struct Sphere {
  dvec3 centre{0.0};
  double radius = 0;

  bool contains(const dvec3& p) const {
    return std::hypot(p.x - centre.x, p.y - centre.y, p.z - centre.z) <= radius;
  }
};

/// Positions p with dot(normal, p) of `offset` or more.
struct HalfSpace {
  dvec3 normal{0.0, 0.0, 1.0};  ///< of any length but 0
  double offset = 0;

  bool contains(const dvec3& p) const { return glm::dot(normal, p) >= offset; }
};

namespace detail {
inline void require_region(bool holds, const char* expected) {
  if (!holds) refuse("crop: expected ", expected);
}
}  // namespace detail

/// Throws `InvalidArgument` for a bad region and names what was expected. Boxes may have infinite
/// sides.
inline void validate(const Box& box) {
  for (int axis = 0; axis < 3; ++axis)
    detail::require_region(
        !detail::is_nan(box.low[axis]) && !detail::is_nan(box.high[axis]) && box.low[axis] <= box.high[axis],
        "a box whose first corner is the lower one");
}
inline void validate(const Sphere& sphere) {
  detail::require_region(detail::is_finite(sphere.centre), "a sphere with a finite centre");
  detail::require_region(detail::is_finite(sphere.radius) && sphere.radius >= 0,
                         "a sphere with a finite radius of 0 or more");
}
inline void validate(const HalfSpace& half) {
  detail::require_region(detail::is_finite(half.normal) && half.normal != dvec3(0.0),
                         "a half-space with a finite normal other than 0");
  detail::require_region(!detail::is_nan(half.offset), "a half-space with a number for its offset");
}

/// The Gaussians that lie in a `Box`, `Sphere` or `HalfSpace` of the world, in their order. Linear in the
/// number of Gaussians. Throws `InvalidArgument` as `validate` does of the scene and the region.
template <class Region>
Scene crop(const Scene& scene, const Region& region) {
  validate(region);
  return subset(scene, select(scene, [&](std::size_t i) {
                  return region.contains(scene.origin + dvec3(scene.means[i]));
                }));
}

namespace detail {
/// The coefficients of a scene for another degree. @shape{N, sh_rest_count(degree), 3}
inline std::vector<float> rest_of_degree(const Scene& scene, int degree) {
  const std::size_t from = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  const std::size_t to = 3 * std::size_t(sh_rest_count(degree)), shared = from < to ? from : to;
  std::vector<float> rest(to * scene.size());
  for (std::size_t i = 0; i < scene.size(); ++i)
    for (std::size_t k = 0; k < shared; ++k) rest[to * i + k] = scene.sh_rest[from * i + k];
  return rest;
}
}  // namespace detail

/// The scene with harmonics of another degree, 0 to 3: bands above it are left out, bands that are missing
/// are zero. Linear in the number of Gaussians. Throws `InvalidArgument` as `validate` does, and for
/// any other degree.
inline Scene with_degree(Scene scene, int degree) {
  validate(scene);
  if (degree < 0 || degree > max_sh_degree) detail::refuse("with_degree: expected 0 to 3, got ", degree);
  if (degree != scene.sh_degree)
    scene.sh_rest = detail::rest_of_degree(scene, degree), scene.sh_degree = degree;
  return scene;
}

/// Adds the Gaussians of `more` behind those of `scene`, which comes to have the higher degree of both. A
/// `more` without Gaussians changes nothing; a `scene` without any takes over the model of `more`, its
/// feature channels and its origin; any other keeps its origin, and `more` is moved to it in double. Linear
/// in the number of added Gaussians, on average, if the degree stays. Throws `InvalidArgument` as
/// `validate` does, if the models of both differ, and if both have features of different numbers of channels.
/// If it throws, `scene` is as before.
inline void append(Scene& scene, const Scene& more) {
  validate(scene), validate(more);
  if (more.size() == 0) return;
  if (&scene == &more) return append(scene, Scene(more));
  if (scene.size() != 0 && scene.model != more.model)
    throw InvalidArgument("append: expected scenes of one rendering model, got two");
  if (scene.size() != 0 && scene.feature_channels != more.feature_channels)
    detail::refuse("append: expected scenes with equally many feature channels, got ", scene.feature_channels,
                   " and ", more.feature_channels);
  if (scene.size() != 0 && scene.origin != more.origin) return append(scene, with_origin(more, scene.origin));
  if (more.sh_degree < scene.sh_degree) return append(scene, with_degree(more, scene.sh_degree));
  if (scene.sh_degree < more.sh_degree) {
    Scene raised = with_degree(scene, more.sh_degree);
    append(raised, more);
    scene = std::move(raised);
    return;
  }

  // All that may throw comes first.
  for_each_array(
      [](const char*, std::size_t, auto& to, const auto& from) {
        const std::size_t needed = to.size() + from.size();
        if (to.capacity() < needed) to.reserve(std::max(needed, 2 * to.capacity()));
      },
      scene, more);
  for_each_array([](const char*, std::size_t, auto& to,
                    const auto& from) { to.insert(to.end(), from.begin(), from.end()); },
                 scene, more);
  scene.model = more.model, scene.feature_channels = more.feature_channels;
  scene.origin = more.origin;
}

}  // namespace swiftgs
