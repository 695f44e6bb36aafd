// SPDX-License-Identifier: Apache-2.0
#include "bench/judge.hpp"

#include <algorithm>
#include <functional>
#include <future>
#include <string_view>
#include <utility>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

namespace swiftgs::cli {
namespace {

/// Clamped to what a photograph can hold.
template <class Values>
PhotoErrors photo_errors(const Image& photo, const Values& colour) {
  std::vector<float> shown(colour.size());
  std::transform(colour.begin(), colour.end(), shown.begin(),
                 [](auto value) { return std::clamp(float(value), 0.0f, 1.0f); });
  return {psnr(shown, photo.pixels), ssim(photo.width, photo.height, 3, shown, photo.pixels)};
}

}  // namespace

Judge::Judge(std::shared_ptr<const Scene> scene, const Camera& camera, const RenderSettings& settings,
             std::optional<Image> photo)
    : scene_(std::move(scene)), camera_(camera), settings_(settings), photo_(std::move(photo)) {}

std::vector<double> Judge::render(Conventions::Footprint footprint) const {
  Conventions conventions = settings_.conventions;
  conventions.footprint = footprint;
  return swiftgs::render_reference(*scene_, camera_, conventions, dvec3(settings_.background)).colour;
}

void Judge::render_reference() {
  if (truth_.empty()) truth_ = render(Conventions::Footprint::alpha);
}

Judge::Verdict Judge::of(const Frame& frame, bool cut) {
  const std::string_view bits(reinterpret_cast<const char*>(frame.colour.data()),
                              frame.colour.size() * sizeof(float));
  const std::pair key(std::hash<std::string_view>()(bits), cut);
  if (const auto found = known_.find(key); found != known_.end()) return found->second;
  Verdict verdict;
  std::future<PhotoErrors> photo;
  if (photo_) photo = std::async(std::launch::async, [&] { return photo_errors(*photo_, frame.colour); });
  if (!truth_.empty()) {
    verdict.errors =
        Errors{psnr(frame.colour, truth_), ssim(frame.width, frame.height, 3, frame.colour, truth_),
               max_abs_difference(frame.colour, truth_), std::nullopt};
    if (cut && cut_truth_.empty()) cut_truth_ = render(Conventions::Footprint::three_sigma_square);
    if (cut) verdict.errors->cut_psnr_db = psnr(frame.colour, cut_truth_);
  }
  if (photo_) verdict.photo = photo.get();
  return known_[key] = verdict;
}

std::optional<PhotoErrors> Judge::reference_photo() const {
  if (!photo_ || truth_.empty()) return std::nullopt;
  return photo_errors(*photo_, truth_);
}

}  // namespace swiftgs::cli
