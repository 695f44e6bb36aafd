// SPDX-License-Identifier: Apache-2.0

#include "measure/prune_judge.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>

#include <swiftgs/metrics.hpp>

#include "draw/team.hpp"
#include "json.hpp"

namespace swiftgs::cli {
namespace {

Json json_of(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json json_of(const PruneSide& side) {
  return {{"gaussians", side.gaussians},
          {"ms", json_of(side.ms)},
          {"photo_psnr_db", json_of(side.photo_psnr_db)},
          {"photo_ssim", json_of(side.photo_ssim)},
          {"unpruned_psnr_db", json_of(side.unpruned_psnr_db)}};
}

void print_row(const char* name, const PruneSide& side) {
  std::printf("%-8s %10zu", name, side.gaussians);
  if (side.ms) std::printf(" %10.2f", *side.ms);
  if (side.photo_psnr_db) std::printf(" %9.2f", *side.photo_psnr_db);
  if (side.photo_ssim) std::printf(" %11.4f", *side.photo_ssim);
  if (side.unpruned_psnr_db) std::printf(" %12.2f", *side.unpruned_psnr_db);
  std::printf("\n");
}

}  // namespace

std::string to_json(const PruneResult& result) {
  const Json json{{"scene", result.scene},
                  {"score", result.score},
                  {"keep", result.keep},
                  {"backend", result.backend},
                  {"conventions", result.conventions},
                  {"views", result.views},
                  {"held_out", result.held_out},
                  {"kept_weight", result.kept_weight},
                  {"before", json_of(result.before)},
                  {"after", json_of(result.after)}};
  return document_of(result.head, members_of(json));
}

void print_table(const PruneResult& result) {
  std::printf("%-8s %10s", "", "Gaussians");
  if (result.before.ms) std::printf(" %10s", "ms a frame");
  if (result.before.photo_psnr_db) std::printf(" %9s", "photo dB");
  if (result.before.photo_ssim) std::printf(" %11s", "photo SSIM");
  if (result.after.unpruned_psnr_db) std::printf(" %12s", "unpruned dB");
  std::printf("\n");
  print_row("before", result.before);
  print_row("after", result.after);
}

namespace {

/// Median time of three frames after one that is not timed. @units{milliseconds}
double time_of(AnyRenderer& renderer, const Camera& camera, const RenderSettings& settings, Frame& frame) {
  std::array<double, 3> ms;
  renderer.render(camera, settings, frame);
  for (double& time : ms) renderer.render(camera, timed(settings), frame), time = renderer.times().total;
  std::sort(ms.begin(), ms.end());
  return ms[1];
}

void add_to(std::optional<double>& sum, std::optional<double> value) {
  if (value) sum = sum.value_or(0) + *value;
}

/// What one view says of a scene.
struct Verdict {
  double ms = 0;
  std::optional<double> unpruned_psnr_db{}, photo_psnr_db{}, photo_ssim{};
};

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
  if (first) unpruned.resize(held_out.views.size());
  Numbered<Verdict> verdicts;
  for (std::size_t i = 0; i < held_out.views.size(); ++i) {
    if (!Team::here().takes(i)) continue;
    progress.start(held_out.views[i].name);
    Verdict verdict{.ms = time_of(*renderer, held_out.views[i].camera, held_out.settings, frame)};
    for (float& value : frame.colour) value = std::clamp(value, 0.0f, 1.0f);  // what a photograph can hold
    if (first)
      unpruned[i] = frame.colour;
    else
      verdict.unpruned_psnr_db = psnr(frame.colour, unpruned[i]);
    if (!held_out.photos.empty() && held_out.photos[i]) {
      const std::vector<float>& photo = held_out.photos[i]->pixels;
      verdict.photo_psnr_db = psnr(frame.colour, photo);
      verdict.photo_ssim = ssim(frame.width, frame.height, 3, frame.colour, photo);
    }
    verdicts.emplace_back(i, verdict);
    progress.step();
  }
  progress.await_others();
  Team::here().join(verdicts);
  std::size_t photos = 0;
  for (const auto& [view, verdict] : verdicts) {
    add_to(side.ms, verdict.ms), add_to(side.unpruned_psnr_db, verdict.unpruned_psnr_db);
    add_to(side.photo_psnr_db, verdict.photo_psnr_db), add_to(side.photo_ssim, verdict.photo_ssim);
    photos += verdict.photo_psnr_db.has_value();
  }
  if (verdicts.empty()) return side;  // of a process that took no view
  *side.ms /= double(held_out.views.size());
  if (side.unpruned_psnr_db) *side.unpruned_psnr_db /= double(held_out.views.size());
  if (photos > 0) *side.photo_psnr_db /= double(photos), *side.photo_ssim /= double(photos);
  return side;
}

}  // namespace swiftgs::cli
