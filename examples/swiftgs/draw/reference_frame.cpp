// SPDX-License-Identifier: Apache-2.0
#include "draw/reference_frame.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

#include <swiftgs/edit/select.hpp>
#include <swiftgs/io/image.hpp>

#include "draw/npy.hpp"

namespace swiftgs::cli {
namespace {

Frame as_floats(const ReferenceFrame& from, bool with_alpha) {
  Frame frame;
  frame.width = from.width, frame.height = from.height;
  frame.colour.assign(from.colour.begin(), from.colour.end());
  if (with_alpha) frame.alpha.assign(from.alpha.begin(), from.alpha.end());
  return frame;
}

}  // namespace

void ReferenceScenes::add(const Scene& scene, const Placement& placement) {
  const std::size_t count = std::min(placement.count, scene.size() - placement.first);
  const Scene* shown = &scene;
  if (count != scene.size()) {
    std::vector<std::uint32_t> kept(count);
    std::iota(kept.begin(), kept.end(), std::uint32_t(placement.first));
    shown = &parts_.emplace_back(subset(scene, kept));
  }
  scenes_.push_back({*shown, placement.world_from_scene, placement.opacity, placement.clip, placement.tint});
}

std::vector<double> ambiguity_of(const ConditionedFrame& frame) {
  std::vector<double> ambiguity = frame.ambiguous[std::size_t(ExponentRepresentation::factor)];
  for (double& weight : ambiguity) weight = std::max(weight, frame.colour_change(weight));
  return ambiguity;
}

void draw_reference(const std::filesystem::path& file, const ReferenceScenes& scenes, const Camera& camera,
                    const RenderSettings& settings) {
  const dvec3 background(settings.background);
  const std::filesystem::path format = file.extension();
  if (format == ".png" || format == ".pfm") {
    const Frame frame = as_floats(render_reference(scenes.all(), camera, settings.conventions, background),
                                  settings.outputs.alpha);
    return format == ".png" ? write_png(file, frame) : write_pfm(file, frame);
  }
  const ConditionedFrame drawn = render_conditioned(scenes.all(), camera, settings.conventions, background);
  const std::vector<double> ambiguity = ambiguity_of(drawn);
  if (format == ".exr") {
    Frame frame = as_floats(drawn.frame, true);
    frame.features.assign(ambiguity.begin(), ambiguity.end()), frame.feature_channels = 1;
    return write_exr(file, frame);
  }
  const std::size_t width = std::size_t(camera.width), height = std::size_t(camera.height);
  write_npy(file, {height, width, 4}, rgba_of(drawn.frame));
  write_npy(std::filesystem::path(file).replace_extension("ambiguous.npy"), {height, width}, ambiguity);
}

}  // namespace swiftgs::cli
