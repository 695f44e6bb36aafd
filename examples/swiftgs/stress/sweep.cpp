// SPDX-License-Identifier: Apache-2.0
#include "stress/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <string>

#include <swiftgs/stress.hpp>

namespace swiftgs::cli {
namespace {

/// Whether `value` is worse than `known` where more is worse. NaN is the worst.
bool is_worse(double value, double known) { return !std::isnan(known) && !(value <= known); }

void add(StressRow& row, const StressVerdict& verdict, std::uint64_t seed) {
  const bool first = row.seeds - row.failed == 1;
  if (first || is_worse(verdict.strict_normalised_error, row.strict_normalised_error))
    row.strict_normalised_error = verdict.strict_normalised_error, row.worst_seed = seed,
    row.worst_pixel = verdict.worst_pixel;
  if (is_worse(verdict.normalised_error, row.normalised_error))
    row.normalised_error = verdict.normalised_error;
  if (is_worse(verdict.normalised_depth_error, row.normalised_depth_error))
    row.normalised_depth_error = verdict.normalised_depth_error;
  if (is_worse(-verdict.psnr_db, -row.psnr_db)) row.psnr_db = verdict.psnr_db;
  if (is_worse(verdict.max_abs, row.max_abs)) row.max_abs = verdict.max_abs;
  row.ambiguity = std::max(row.ambiguity, verdict.ambiguity),
  row.allowed = std::max(row.allowed, verdict.allowed);
  row.judged = std::min(row.judged, verdict.judged);
  row.flips += verdict.flips;
}

StressRow row_of(const StressPoint& point, std::string_view renderer) {
  StressRow row;
  row.family = point.family->name, row.severity_label = point.family->severity;
  row.severity = point.severity;
  row.width = point.size.width, row.height = point.size.height;
  row.renderer = renderer;
  row.psnr_db = std::numeric_limits<double>::infinity();
  return row;
}

}  // namespace

Sweep::Sweep(std::vector<RendererEntry> entries, int seeds, int threads) : seeds_(seeds), threads_(threads) {
  for (const RendererEntry& entry : entries) subjects_.push_back({entry, nullptr});
}

std::vector<StressRow> Sweep::run(const StressPoint& point, Progress& progress) {
  std::vector<StressRow> rows;
  for (const Subject& subject : subjects_) rows.push_back(row_of(point, subject.entry.name));
  for (int seed = 1; seed <= seeds_; ++seed) draw_seed(point, std::uint64_t(seed), rows, progress);
  return rows;
}

void Sweep::draw_seed(const StressPoint& point, std::uint64_t seed, std::vector<StressRow>& rows,
                      Progress& progress) {
  const StressCase made = point.family->make(point.severity, seed, point.size);
  const auto scene = std::make_shared<const Scene>(made.scene);
  const RenderSettings settings{
      .conventions = made.conventions, .background = made.background, .outputs = {true, true}};
  const Placement placement{.world_from_scene = made.world_from_scene, .clip = made.clip};
  const ConditionedFrame reference = render_conditioned(made, seed, threads_);
  for (std::size_t i = 0; i < subjects_.size(); ++i) {
    Subject& subject = subjects_[i];
    progress.start(std::string(point.family->name) + " " + severity_text(point.severity) + ": " +
                   subject.entry.name);
    ++rows[i].seeds;
    Frame frame;
    try {
      if (!subject.renderer) subject.renderer = subject.entry.make();
      subject.renderer->set_scene(scene);
      subject.renderer->place({&placement, 1});
      subject.renderer->render(made.camera, settings, frame);
      add(rows[i], judge(reference, frame, exponent_representation_named(subject.entry.name)), seed);
    } catch (const std::exception& error) {
      if (rows[i].failed++ == 0) rows[i].error = "seed " + std::to_string(seed) + ": " + error.what();
      subject.renderer.reset();
    }
    progress.step();
  }
}

}  // namespace swiftgs::cli
