// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/lens.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/passes.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/project/project.hpp>

namespace swiftgs {

/// The axis along which a Gaussian is shortest; of equal ones the first.
SWIFTGS_HD inline int shortest_axis(vec3 scale) {
  const int first = scale.y < scale.x ? 1 : 0;
  return scale.z < scale[first] ? 2 : first;
}

/// Normal of Gaussian `i` in camera space: a unit vector along its shortest axis that points against the ray
/// through its mean.
SWIFTGS_HD inline vec3 splat_normal(const ViewConstants& v, const SceneView& scene, std::size_t i) {
  const Gaussian g = gaussian(scene, i);
  const vec3 axis = LocalAxes<float>(g.rotation).column[shortest_axis(g.scale)];
  vec3 normal;
  for (int row = 0; row < 3; ++row)
    normal[row] = dot(vec3(v.axes[row][0], v.axes[row][1], v.axes[row][2]), axis);
  vec3 ray(0, 0, 1);
  if (v.lens.model != LensModel::orthographic) {
    const CameraPoint at(v, g.mean);
    ray = vec3(float(at.p[0]), float(at.p[1]), float(at.p[2]));
  }
  return dot(normal, ray) > 0 ? -normal : normal;
}

/// The attributes of splats that a stage gathers. Pointers are to memory that the backend reaches.
struct SplatAttributes {
  SplatsView splats;
  int first = 0;      ///< attribute of the frame
  unsigned rows = 0;  ///< of `AttributesView`

  /// Whether views may need depths along the ray here. Their arithmetic takes a device many registers.
  bool along_ray(Span<const View> views) const {
    return first == 0 && std::any_of(views.begin(), views.end(), asks_for_ray_depth);
  }

  /// Writes the rows of splat `i`, which `view` shows. `some_along_ray`: as of `along_ray`.
  template <bool some_along_ray, class Scenes>
  SWIFTGS_HD void gather(const Scenes& scenes, const View& view, std::size_t i, AttributeRow* to) const {
    const auto seen = scenes.see(view.camera, splats.gaussians[i]);
    Geometry of{.depth = drawn_depth(seen.camera, seen.scene, seen.i, splats.depths[i])};
    if (some_along_ray && asks_for_ray_depth(view))
      of.along_ray = ray_depth(seen.camera, gaussian(seen.scene, seen.i), splats.shapes[i].exact_mean(),
                               of.depth, most_attribute(view.rules.alpha_max));
    // Both are among the first attributes of a frame.
    if (first == 0 && view.request.normal) of.normal = splat_normal(seen.camera, seen.scene, seen.i);
    const float* features = seen.scene.features.at(seen.i);
    for (unsigned r = 0; r < rows; ++r) to[i * rows + r] = row(view, r, of, features);
  }

 private:
  struct Geometry {
    float depth = 0;
    RayDepth along_ray{};
    vec3 normal{0};
  };

  /// A number that is not finite counts as 0. Larger magnitudes than `most_attribute` are cut to it.
  SWIFTGS_HD AttributeRow row(const View& view, unsigned r, const Geometry& of, const float* features) const {
    const float largest = 3.4028234663852886e38f, most = most_attribute(view.rules.alpha_max);
    AttributeRow out;
    for (unsigned c = 0; c < AttributeRow::channels; ++c) {
      const Attribute from = attribute(view, view.request, first + int(r * AttributeRow::channels + c));
      float value = 0;
      switch (from.of) {
        case Attribute::Of::ray_depth:
          value = from.channel == 0   ? of.along_ray.middle
                  : from.channel == 1 ? of.along_ray.x
                                      : of.along_ray.y;
          break;
        case Attribute::Of::squared_ray_depth:
          value = of.along_ray.square(from.channel);
          break;
        case Attribute::Of::normal:
          value = of.normal[from.channel];
          break;
        case Attribute::Of::squared_depth:
          value = of.depth * of.depth < most ? of.depth * of.depth : most;  // it may be infinite
          break;
        case Attribute::Of::feature:
          value = features[from.channel];
          break;
        case Attribute::Of::nothing:
          break;
      }
      const bool finite = value >= -largest && value <= largest;
      out.values[c] = !finite ? 0.0f : value < -most ? -most : value > most ? most : value;
    }
    return out;
  }
};

template <class Scenes>
struct GatherAttributes {
  SplatAttributes from;
  Scenes scenes;
  const View* views;
  AttributeRow* to;

  void operator()(std::size_t i) const {
    from.template gather<true>(scenes, views[from.splats.view(i)], i, to);
  }
};

/// Writes attributes of all splats to `to`, @shape{splats, rows}, on hosts. A device overloads this.
template <FunctorBackend B>
requires(bool(B::reaches_host_memory)) void gather_attributes(B& b, const SplatAttributes& from,
                                                              const StoredScenes& scenes, const Views& views,
                                                              AttributeRow* to) {
  with_scenes(scenes, [&]<class Scenes>(const Scenes& of) {
    b.for_each(from.splats.count(), GatherAttributes<Scenes>{from, of, views.each.data, to});
  });
}

}  // namespace swiftgs
