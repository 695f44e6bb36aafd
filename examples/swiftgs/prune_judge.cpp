// SPDX-License-Identifier: Apache-2.0
#include "prune_judge.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include <swiftgs/metrics.hpp>

namespace swiftgs::cli {
namespace {

/// Median time of three frames after one that is not timed. @units{milliseconds}
double time_of(AnyRenderer& renderer, const Camera& camera, const RenderSettings& settings, Frame& frame) {
  std::array<double, 3> ms;
  renderer.render(camera, settings, frame);
  for (double& time : ms) renderer.render(camera, timed(settings), frame), time = renderer.times().total;
  std::sort(ms.begin(), ms.end());
  return ms[1];
}

void add_to(std::optional<double>& sum, double value) { sum = sum.value_or(0) + value; }

}  // namespace

PruneSide judge(const HeldOut& held_out, const std::shared_ptr<const Scene>& scene,
                std::vector<std::vector<float>>& unpruned, Progress& progress) {
  PruneSide side;
  side.gaussians = scene->size();
  if (held_out.views.empty()) return side;
  const bool first = unpruned.empty();
  const std::unique_ptr<AnyRenderer> renderer = make_renderer(held_out.renderer);
  renderer->set_scene(scene);
  Frame frame;
  std::size_t photos = 0;
  for (std::size_t i = 0; i < held_out.views.size(); ++i) {
    progress.start(held_out.views[i].name);
    add_to(side.ms, time_of(*renderer, held_out.views[i].camera, held_out.settings, frame));
    for (float& value : frame.colour) value = std::clamp(value, 0.0f, 1.0f);  // what a photograph can hold
    if (first)
      unpruned.push_back(frame.colour);
    else
      add_to(side.unpruned_psnr_db, psnr(frame.colour, unpruned[i]));
    if (!held_out.photos.empty() && held_out.photos[i]) {
      const std::vector<float>& photo = held_out.photos[i]->pixels;
      add_to(side.photo_psnr_db, psnr(frame.colour, photo));
      add_to(side.photo_ssim, ssim(frame.width, frame.height, 3, frame.colour, photo));
      ++photos;
    }
    progress.step();
  }
  *side.ms /= double(held_out.views.size());
  if (side.unpruned_psnr_db) *side.unpruned_psnr_db /= double(held_out.views.size());
  if (photos > 0) *side.photo_psnr_db /= double(photos), *side.photo_ssim /= double(photos);
  return side;
}

}  // namespace swiftgs::cli
