// SPDX-License-Identifier: Apache-2.0
#include "view/crop_error.hpp"

#include <algorithm>
#include <chrono>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "draw/reference_frame.hpp"

namespace swiftgs::cli {
namespace {

/// The reference's colours of the placed scenes.
std::vector<double> colours_of(const std::vector<PlacedGaussians>& shown, const Camera& camera,
                               const RenderSettings& settings) {
  ReferenceScenes scenes;
  for (const PlacedGaussians& each : shown) scenes.add(*each.gaussians, each.placement);
  return render_reference(scenes.all(), camera, settings.conventions, dvec3(settings.background)).colour;
}

}  // namespace

Camera crop_around(const Camera& camera, int x, int y, int side) {
  Camera crop = camera;
  crop.width = std::min(side, camera.width), crop.height = std::min(side, camera.height);
  crop.cx -= std::clamp(x - crop.width / 2, 0, camera.width - crop.width);
  crop.cy -= std::clamp(y - crop.height / 2, 0, camera.height - crop.height);
  return crop;
}

bool CropError::Subject::operator==(const Subject& other) const {
  const Camera &a = crop, &b = other.crop;
  return version == other.version && a.rotation == b.rotation && a.translation == b.translation &&
         a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy && a.width == b.width &&
         a.height == b.height && a.lens == b.lens;
}

std::optional<CropError::Error> CropError::of(Drawing& drawing, const Camera& crop) {
  const Subject now{crop, drawing.version()};
  if (running_.valid() && running_.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
    reference_ = running_.get(), subject_ = running_subject_, renderer_.clear();
  if (reference_.empty() || !(subject_ == now)) {
    if (!running_.valid()) {
      running_subject_ = now;
      running_ = std::async(std::launch::async, colours_of, drawing.visible(), crop, drawing.settings());
    }
    return std::nullopt;
  }
  if (renderer_ != drawing.renderer().name()) {
    const std::vector<float> colour = drawing.draw_apart(crop);
    error_ = {psnr(colour, reference_), max_abs_difference(colour, reference_)};
    renderer_ = drawing.renderer().name();
  }
  return error_;
}

}  // namespace swiftgs::cli
