// SPDX-License-Identifier: Apache-2.0

#include "draw/lenses.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include <swiftgs/camera.hpp>
#include <swiftgs/tools/scene_bounds.hpp>

namespace swiftgs::cli {
namespace {

/// The view of `camera` with a whole turn in a row and half a turn in a column.
Camera whole_panorama(Camera camera) {
  camera.fx = camera.width / (2 * std::numbers::pi), camera.fy = camera.height / std::numbers::pi;
  camera.cx = 0.5 * camera.width, camera.cy = 0.5 * camera.height;
  return camera;
}

/// The view of `camera` through a lens without distortion.
Camera through(LensModel model, Camera camera, dvec3 middle) {
  camera.lens = {model, {}};
  if (traits_of(model).shows_sphere) return whole_panorama(camera);
  if (!traits_of(model).parallel_rays) return camera;
  // What is as far away as the middle of the scene keeps its size.
  const dvec3 away = middle - camera.centre();
  const double distance = std::sqrt(detail::dot(away, away));
  if (distance > 0) camera.fx /= distance, camera.fy /= distance;
  return camera;
}

}  // namespace

void add_lens(CLI::App& command, LensOptions& options) {
  command.add_option("--lens", options.lens,
                     "Lens in place of the cameras', without distortion: perspective and fisheye with\n"
                     "the focal lengths of the camera, orthographic with the size that it shows in\n"
                     "the middle of the scene, or equirectangular, all around [that of each camera]");
  command.add_flag("--panorama", options.panorama,
                   "All around the camera, twice as wide as high, as wide as its image");
  command.add_option("--depth-by", options.depth_by,
                     "What orders Gaussians and is compared with the near plane: z or distance\n"
                     "[distance of lenses that see behind the camera, else z]");
  command
      .add_option("--depth-at", options.depth_at,
                  "A Gaussian's depth at a pixel, for planes of depth: that of its centre, or\n"
                  "along the pixel's ray, centre or ray")
      ->capture_default_str();
}

void validate(const LensOptions& options) {
  if (!options.lens.empty()) {
    try {
      lens_model_named(options.lens);
    } catch (const std::invalid_argument&) {
      throw std::invalid_argument("--lens '" + options.lens + "': expected " + lens_model_names());
    }
  }
  if (options.panorama && !options.lens.empty() && options.lens != name_of(LensModel::equirectangular))
    throw std::invalid_argument("--panorama: expected no --lens " + options.lens + " beside it");
  depth_of(options), depth_at_of(options);
}

Conventions::Depth depth_of(const LensOptions& options) {
  if (options.depth_by.empty()) return Conventions::Depth::of_lens;
  if (options.depth_by == "z") return Conventions::Depth::z;
  if (options.depth_by == "distance") return Conventions::Depth::distance;
  throw std::invalid_argument("--depth-by '" + options.depth_by + "': expected z or distance");
}

Conventions::DepthAt depth_at_of(const LensOptions& options) {
  if (options.depth_at == "centre") return Conventions::DepthAt::centre;
  if (options.depth_at == "ray") return Conventions::DepthAt::ray;
  throw std::invalid_argument("--depth-at '" + options.depth_at + "': expected centre or ray");
}

void use_lens(std::vector<View>& views, const LensOptions& options, const Scene& scene) {
  if (!options.panorama && options.lens.empty()) return;
  const LensModel model = options.panorama ? LensModel::equirectangular : lens_model_named(options.lens);
  const dvec3 middle = traits_of(model).parallel_rays ? robust_bounds(scene).centre : dvec3(0.0);
  for (View& view : views) {
    Camera& camera = view.camera;
    if (options.panorama) camera.height = std::max(1, camera.width / 2);
    camera = through(model, camera, middle);
    validate(camera);
  }
}

std::string words_of(const Lens& lens) {
  return std::string(name_of(lens.model)) + (lens.is_distorted() ? ", distorted" : "");
}

void print(const RenderResult& result) {
  const StageTimes& ms = result.ms;
  const bool is_pinhole = result.lens == words_of(Lens());
  std::printf("%s  %dx%d  %s%.2f ms (project %.2f, sort %.2f, raster %.2f)\n", result.image.c_str(),
              result.width, result.height, is_pinhole ? "" : (result.lens + "  ").c_str(), ms.total,
              ms.project, ms.sort, ms.raster);
  if (!result.counts) return;
  const Statistics& s = *result.counts;

  const auto line = [](const char* label, std::uint64_t count) {
    std::printf("  %-33s %llu\n", label, static_cast<unsigned long long>(count));
  };
  line("Gaussians", s.gaussians);
  line("visible", s.visible);
  line("intersections", s.intersections);
  std::printf("  %-33s %.2f\n", "intersections a visible Gaussian", s.intersections_a_visible());
  line("contributing pairs", s.raster.contributing_pairs);
  line("pixels stopped early", s.raster.pixels_stopped);
}

}  // namespace swiftgs::cli
