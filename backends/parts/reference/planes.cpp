// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/reference.hpp>
#include <swiftgs/tools/parallel.hpp>

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
  const bool parallel = traits_of(view.camera.lens.model).parallel_rays;
  const Eigen::Vector3d ray = parallel ? Eigen::Vector3d(0, 0, 1) : camera_space_mean(scene, i, view);
  const double cosine = axis.dot(ray.stableNormalized());
  return {cosine > 0 ? -axis : axis, std::abs(cosine) < least_cosine};
}

/// What planes show of a Gaussian besides its splat.
struct Attributes {
  Normal normal;
  const float* features;
};

/// Attributes of all Gaussians, by their numbers.
std::vector<Attributes> attributes_of(const std::vector<View>& views) {
  std::vector<Attributes> all;
  for (const View& view : views) {
    const Scene& scene = view.placed.scene;
    for (std::size_t i = 0; i < scene.size(); ++i)
      all.push_back({normal(i, view), scene.features.data() + std::size_t(scene.feature_channels) * i});
  }
  return all;
}

/// A pixel of `out`, whose planes it collects.
struct PlanesPixel {
  ReferencePlanes& out;
  std::size_t i;
  Pixel blended{};

  /// Offers a splat.
  void offer(const Splat& splat, const Attributes& of, int x, int y, const Conventions& k) {
    if (blended.stopped) return;
    const double dy = y + 0.5 - splat.y, along = x + 0.5 - splat.x - splat.shear * dy;
    const double sigma = 0.5 * (splat.x_weight * along * along + splat.y_weight * dy * dy);
    const double alpha = std::min(double(k.alpha_max), splat.opacity * std::exp(-sigma));
    approach(out.threshold_margin[i], alpha / double(k.alpha_min), 1);
    const double before = blended.transmittance;
    if (alpha >= double(k.alpha_min) && k.stop > 0)
      approach(out.threshold_margin[i], before * (1 - alpha) / double(k.stop), 1);
    const double depth = splat.depth_at(x, y);
    if (alpha >= double(k.alpha_min) && std::isfinite(blended.occluder))
      approach(out.occluder_margin[i], double(blended.occluder) / depth, 1);
    if (!blend(blended, splat, sigma, depth, k)) return;

    const double left = blended.transmittance, part = alpha * before, most = most_attribute(k.alpha_max);
    out.squared_depth[i] += part * std::min(depth * depth, most);
    for (std::size_t c = 0; c < 3; ++c) out.normal[3 * i + c] += part * of.normal.direction[Eigen::Index(c)];
    if (of.normal.undecided) out.undecided_normals[i] += part;
    const std::size_t channels = std::size_t(out.feature_channels);
    for (std::size_t c = 0; c < channels; ++c)
      if (std::isfinite(of.features[c]))
        out.features[channels * i + c] += part * std::clamp(double(of.features[c]), -most, most);
    const auto gaussian = std::uint32_t(splat.index);
    pick(gaussian, part, depth);
    const auto takes_below = [&](double threshold, double& margin) {
      approach(margin, left, threshold);
      return before >= threshold && left < threshold;
    };
    if (takes_below(1 - double(k.first_alpha), out.first_margin[i])) out.first_depth[i] = depth;
    if (takes_below(0.5, out.median_margin[i])) out.median_depth[i] = depth, out.median_id[i] = gaussian;
  }

  /// Ends sums and means. `linear`: colours were blended in linear light.
  void finish(bool linear) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double colour = blended.colour[Eigen::Index(c)];
      out.colour[3 * i + c] = linear ? encoded(colour) : colour;
    }
    out.alpha[i] = 1 - blended.transmittance, out.depth[i] = blended.depth;
    for_each_plane(
        [&]<class T>(std::size_t, std::vector<T>& values, const PlaneRow& row) {
          if (row.accumulator == Accumulator::mean && blended.weight > 0) values[i] /= T(blended.weight);
        },
        out, plane_table);
  }

 private:
  static void approach(double& margin, double value, double threshold) {
    margin = std::min(margin, std::abs(value - threshold));
  }
  void pick(std::uint32_t gaussian, double part, double depth) {
    if (part > out.weight[i]) {
      out.next_weight[i] = out.weight[i];
      out.id[i] = gaussian, out.weight[i] = part, out.depth_of_id[i] = depth;
    } else {
      out.next_weight[i] = std::max(out.next_weight[i], part);
    }
  }
};

/// Gives the planes of `out` the size of the camera's image, and pixels without splats.
void prepare(ReferencePlanes& out, const Camera& camera, int feature_channels) {
  out.width = camera.width, out.height = camera.height, out.feature_channels = feature_channels;
  for_each_plane(
      [&]<class T>(std::size_t channels, std::vector<T>& values) {
        values.assign(channels * out.pixels(), std::is_same_v<T, std::uint32_t> ? T(no_gaussian) : T(0));
      },
      out);
  for (auto* values : {&out.weight, &out.next_weight, &out.depth_of_id, &out.undecided_normals})
    values->resize(out.pixels());
  for (auto* margins : {&out.first_margin, &out.median_margin, &out.threshold_margin, &out.occluder_margin})
    margins->assign(out.pixels(), std::numeric_limits<double>::infinity());
}

/// Blends `splats`, front to back, into the image rows [first, last).
void render_rows(ReferencePlanes& out, const std::vector<Attributes>& attributes,
                 const std::vector<const Splat*>& splats, int first, int last, const Conventions& conventions,
                 Span<const float> occluder) {
  const std::size_t width = std::size_t(out.width);
  std::vector<PlanesPixel> pixels;
  for (std::size_t i = width * std::size_t(first); i < width * std::size_t(last); ++i) {
    pixels.push_back({out, i});
    if (occluder.size > 0) pixels.back().blended.occluder = occluder[i];
  }
  for (const Splat* splat : splats)
    for (int y = std::max(first, splat->y_begin); y < std::min(last, splat->y_end); ++y)
      for (int x = splat->x_begin; x < splat->x_end; ++x)
        pixels[width * std::size_t(y - first) + std::size_t(x)].offer(*splat, attributes[splat->index], x, y,
                                                                      conventions);
  for (PlanesPixel& pixel : pixels) pixel.finish(*conventions.colours == ColourSpace::linear);
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
