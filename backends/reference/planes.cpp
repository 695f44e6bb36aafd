// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <swiftgs/parallel.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/reference/planes.hpp>

#include "blending.hpp"
#include "rendering.hpp"

namespace swiftgs {
namespace reference {
namespace {

/// Normal of a Gaussian in camera space.
struct Normal {
  Eigen::Vector3d direction;
  bool undecided;  ///< across the ray as far as float can tell, so that it may point either way
};

Normal normal(std::size_t i, const View& view) {
  constexpr double least_cosine = 1e-5;
  const Scene& scene = view.placed.scene;
  const Quaternion& q = scene.rotations[i];
  const vec3& s = scene.scales[i];
  const double scales[] = {s.x, s.y, s.z};
  const auto shortest = std::min_element(scales, scales + 3) - scales;
  const Eigen::Matrix3d axes = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
  const Eigen::Vector3d axis = view.rotation * axes.col(shortest);
  const bool parallel = view.camera.lens.model == LensModel::orthographic;
  const Eigen::Vector3d ray = parallel ? Eigen::Vector3d(0, 0, 1) : camera_space_mean(scene, i, view);
  const double cosine = axis.dot(ray.stableNormalized());
  return {cosine > 0 ? -axis : axis, std::abs(cosine) < least_cosine};
}

/// What planes show of a Gaussian besides its splat.
struct Attributes {
  Normal normal;
  const float* features;
};

/// Those of all Gaussians, by their numbers.
std::vector<Attributes> attributes_of(const std::vector<View>& views) {
  std::vector<Attributes> all;
  for (const View& view : views) {
    const Scene& scene = view.placed.scene;
    for (std::size_t i = 0; i < scene.size(); ++i)
      all.push_back({normal(i, view), scene.features.data() + std::size_t(scene.feature_channels) * i});
  }
  return all;
}

/// What a pixel has collected so far.
struct PlanesPixel {
  static constexpr double nowhere = std::numeric_limits<double>::infinity();

  Pixel blended;
  double squared_depth = 0;  ///< sum of weight * depth^2
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double undecided_normals = 0;
  double first_depth = 0, median_depth = 0, weight = 0, next_weight = 0, depth_of_id = 0;
  std::uint32_t id = no_gaussian, median_id = no_gaussian;
  double first_margin = nowhere, median_margin = nowhere, threshold_margin = nowhere;
  double occluder_margin = nowhere;

  /// Offers a splat; returns its weight, 0 where it does not show.
  double offer(const Splat& splat, const Normal& facing, int x, int y, const Conventions& k) {
    if (blended.stopped) return 0;
    const double dy = y + 0.5 - splat.y, along = x + 0.5 - splat.x - splat.shear * dy;
    const double sigma = 0.5 * (splat.x_weight * along * along + splat.y_weight * dy * dy);
    const double alpha = std::min(double(k.alpha_max), splat.opacity * std::exp(-sigma));
    approach(threshold_margin, alpha / double(k.alpha_min), 1);
    const double before = blended.transmittance;
    if (alpha >= double(k.alpha_min) && k.stop > 0)
      approach(threshold_margin, before * (1 - alpha) / double(k.stop), 1);
    const double depth = splat.depth_at(x, y);
    if (alpha >= double(k.alpha_min) && std::isfinite(blended.occluder))
      approach(occluder_margin, double(blended.occluder) / depth, 1);
    if (!blend(blended, splat, sigma, depth, k)) return 0;

    const double left = blended.transmittance, part = alpha * before;
    squared_depth += part * std::min(depth * depth, double(most_attribute(k.alpha_max)));
    normal += part * facing.direction;
    if (facing.undecided) undecided_normals += part;
    pick(std::uint32_t(splat.index), part, depth);
    const auto takes_below = [&](double threshold, double& margin) {
      approach(margin, left, threshold);
      return before >= threshold && left < threshold;
    };
    if (takes_below(1 - double(k.first_alpha), first_margin)) first_depth = depth;
    if (takes_below(0.5, median_margin)) median_depth = depth, median_id = std::uint32_t(splat.index);
    return part;
  }

 private:
  static void approach(double& margin, double value, double threshold) {
    margin = std::min(margin, std::abs(value - threshold));
  }
  void pick(std::uint32_t gaussian, double part, double depth) {
    if (part > weight) {
      next_weight = weight;
      id = gaussian, weight = part, depth_of_id = depth;
    } else {
      next_weight = std::max(next_weight, part);
    }
  }
};

/// Gives the planes of `out` the size of the camera's image.
void prepare(ReferencePlanes& out, const Camera& camera, int feature_channels) {
  out.width = camera.width, out.height = camera.height, out.feature_channels = feature_channels;
  for_each_plane([&](std::size_t channels, auto& values) { values.resize(channels * out.pixels()); }, out);
  for (auto* margins :
       {&out.weight, &out.next_weight, &out.depth_of_id, &out.first_margin, &out.median_margin,
        &out.undecided_normals, &out.threshold_margin, &out.occluder_margin})
    margins->resize(out.pixels());
}

/// Writes pixel `i` but its features. `linear`: colours were blended in linear light.
void write_pixel(ReferencePlanes& out, std::size_t i, const PlanesPixel& pixel, bool linear) {
  const Pixel& blended = pixel.blended;
  const auto mean = [&](double sum) { return blended.weight > 0 ? sum / blended.weight : 0; };
  for (std::size_t c = 0; c < 3; ++c) {
    const double colour = blended.colour[Eigen::Index(c)];
    out.colour[3 * i + c] = linear ? encoded(colour) : colour;
    out.normal[3 * i + c] = pixel.normal[Eigen::Index(c)];
  }
  out.alpha[i] = 1 - blended.transmittance;
  out.depth[i] = mean(blended.depth), out.squared_depth[i] = mean(pixel.squared_depth);
  out.first_depth[i] = pixel.first_depth, out.median_depth[i] = pixel.median_depth;
  out.id[i] = pixel.id, out.median_id[i] = pixel.median_id;
  out.weight[i] = pixel.weight, out.next_weight[i] = pixel.next_weight;
  out.depth_of_id[i] = pixel.depth_of_id;
  out.first_margin[i] = pixel.first_margin, out.median_margin[i] = pixel.median_margin;
  out.undecided_normals[i] = pixel.undecided_normals, out.threshold_margin[i] = pixel.threshold_margin;
  out.occluder_margin[i] = pixel.occluder_margin;
}

/// Blends `splats`, front to back, into the image rows [first, last).
void render_rows(ReferencePlanes& out, const std::vector<Attributes>& attributes,
                 const std::vector<const Splat*>& splats, int first, int last, const Conventions& conventions,
                 Span<const float> occluder) {
  const std::size_t width = std::size_t(out.width), begin = width * std::size_t(first);
  const std::size_t channels = std::size_t(out.feature_channels);
  std::vector<PlanesPixel> pixels(width * std::size_t(last - first));
  for (std::size_t i = 0; occluder.size > 0 && i < pixels.size(); ++i)
    pixels[i].blended.occluder = occluder[begin + i];
  for (const Splat* splat : splats)
    for (int y = std::max(first, splat->y_begin); y < std::min(last, splat->y_end); ++y)
      for (int x = splat->x_begin; x < splat->x_end; ++x) {
        const std::size_t i = width * std::size_t(y - first) + std::size_t(x);
        const Attributes& of = attributes[splat->index];
        const double weight = pixels[i].offer(*splat, of.normal, x, y, conventions);
        for (std::size_t c = 0; weight > 0 && c < channels; ++c) {
          const float feature = of.features[c];
          const double most = most_attribute(conventions.alpha_max);
          if (std::isfinite(feature))
            out.features[channels * (begin + i) + c] += weight * std::clamp(double(feature), -most, most);
        }
      }
  for (std::size_t i = 0; i < pixels.size(); ++i)
    write_pixel(out, begin + i, pixels[i], *conventions.colours == ColourSpace::linear);
}

}  // namespace
}  // namespace reference

ReferencePlanes render_reference_planes(Span<const ReferenceScene> scenes, const Camera& camera,
                                        const Conventions& given, int threads, Span<const float> occluder) {
  using namespace reference;
  check_reference_arguments(scenes, camera, dvec3(0), occluder);
  const Conventions conventions = of_frame(given, scenes, occluder.size != 0);
  threads = thread_count(threads);
  const std::vector<reference::View> views = views_of(scenes, camera, conventions);
  const SplatChunks chunks = project_all(views, threads);
  const std::vector<std::vector<const Splat*>> strips = sort_into_strips(chunks, camera.height);
  const std::vector<Attributes> attributes = attributes_of(views);

  int channels = scenes.empty() ? 0 : max_feature_channels;
  for (const ReferenceScene& placed : scenes) channels = std::min(channels, placed.scene.feature_channels);
  ReferencePlanes out;
  prepare(out, camera, channels);
  for_each_index(strips.size(), threads, [&](std::size_t strip) {
    const int first = int(strip) * strip_rows, last = std::min(camera.height, first + strip_rows);
    render_rows(out, attributes, strips[strip], first, last, conventions, occluder);
  });
  return out;
}

}  // namespace swiftgs
