// SPDX-License-Identifier: Apache-2.0

#include "bench/measure.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <swiftgs/metrics.hpp>
#include <swiftgs/reference.hpp>

#include "interruptible.hpp"
#include "read/views.hpp"

namespace swiftgs::cli {
namespace {

constexpr int frames_a_turn = 4;

/// Twice as many as an adaptive sort measures.
constexpr int most_frames_to_adapt = 20;

/// The value below which `part` of the sorted `values` lie, between neighbours in proportion.
double percentile(const std::vector<double>& values, double part) {
  const double at = part * double(values.size() - 1);
  const std::size_t below = std::size_t(at), above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - double(below)) * (values[above] - values[below]);
}

void add_frame(AnyRenderer& renderer, Span<const Camera> cameras, const RenderSettings& settings,
               Samples& samples) {
  using Clock = std::chrono::steady_clock;
  const RenderSettings with_times = timed(settings);
  const auto start = Clock::now();
  renderer.render_resident(cameras, with_times);
  const double wall = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  const StageTimes ms = a_view(renderer.times(), cameras.size);
  samples.project.push_back(ms.project), samples.sort.push_back(ms.sort);
  samples.raster.push_back(ms.raster), samples.total.push_back(ms.total);
  samples.wall.push_back(wall / double(cameras.size));
}

bool precise(const Samples& samples, const Plan& plan) {
  if (samples.frames() >= plan.max_frames) return true;
  if (samples.frames() < plan.min_frames) return false;
  const Duration total = summary_of(samples.total);
  return total.high - total.low <= 2 * plan.precision * total.median;
}

}  // namespace

void validate(const Plan& plan) {
  if (plan.min_frames < 1) throw std::invalid_argument("--min-frames: expected at least 1");
  if (plan.max_frames < plan.min_frames)
    throw std::invalid_argument("--max-frames: expected at least the " + std::to_string(plan.min_frames) +
                                " of --min-frames");
  if (!(plan.precision > 0))
    throw std::invalid_argument("--precision: expected a part above 0, such as 0.01");
}

Duration summary_of(std::vector<double> values) {
  if (values.empty()) throw std::invalid_argument("summary: expected at least one value");
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  // How many values lie below the true median is binomial, of variance n / 4: 1.96 deviations from n / 2, and
  // half a value because they are counted, hold 95 of 100 cases.
  const double rank = 0.5 * double(n) - 0.5 * 1.96 * std::sqrt(double(n)) - 0.5;
  const std::size_t low = rank > 0 ? std::size_t(rank) : 0;
  return {percentile(values, 0.5), values[low], values[n - 1 - low], percentile(values, 0.1),
          percentile(values, 0.9)};
}

Durations Samples::summary() const {
  return {summary_of(project), summary_of(sort), summary_of(raster), summary_of(total), summary_of(wall)};
}

void adapt(AnyRenderer& renderer, Span<const Camera> cameras, const RenderSettings& settings) {
  int frames = 0;
  do renderer.render_resident(cameras, settings), ++frames;
  while (!renderer.sort_decided() && frames < most_frames_to_adapt);
}

std::vector<Samples> measure(const std::vector<AnyRenderer*>& renderers, Span<const Camera> cameras,
                             const RenderSettings& settings, const Plan& plan,
                             const std::function<void(std::size_t, const Samples&)>& finished) {
  std::vector<Samples> samples(renderers.size());
  std::vector<std::size_t> order(renderers.size());
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(plan.seed);
  while (!order.empty()) {
    std::shuffle(order.begin(), order.end(), random);
    for (const std::size_t i : order) {
      renderers[i]->render_resident(cameras, settings);
      for (int frame = 0; frame < frames_a_turn && samples[i].frames() < plan.max_frames; ++frame) {
        Interruptible::stop_if_interrupted();
        add_frame(*renderers[i], cameras, settings, samples[i]);
      }
      if (finished && precise(samples[i], plan)) finished(i, samples[i]);
    }
    std::erase_if(order, [&](std::size_t i) { return precise(samples[i], plan); });
  }
  return samples;
}

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
