// SPDX-License-Identifier: Apache-2.0

#include "stress/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string_view>

#include <swiftgs/camera.hpp>

#include "bench/variants.hpp"
#include "json.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

ImageSize size_named(const std::string& text) {
  const std::vector<std::string_view> sides = cli::split(text, 'x');
  const auto side = [&](std::size_t i) { return i < sides.size() ? parse<int>(sides[i]).value_or(0) : 0; };
  const ImageSize size{side(0), side(1)};
  const auto fits = [](int pixels) { return pixels >= 1 && pixels <= max_image_side; };
  if (sides.size() != 2 || !fits(size.width) || !fits(size.height))
    throw std::invalid_argument("--size '" + text + "': expected WIDTHxHEIGHT such as 64x48, each 1 to " +
                                std::to_string(max_image_side));
  return size;
}

/// The severities of `family` that `text` asks for: `max`, `all`, or numbers. Throws for a number outside of
/// the family's own range: a scene of any size could follow from it.
std::vector<double> severities_named(const std::string& text, const StressFamily& family) {
  if (text == "all") return family.severities;
  const double least = family.severities.front(), most = family.severities.back();
  if (text == "max") return {most};
  std::vector<double> severities;
  try {
    severities = numbers_of("--severity", text);
  } catch (const std::invalid_argument&) {
    throw std::invalid_argument("--severity '" + text +
                                "': expected max, all, or numbers separated by commas, each once");
  }
  for (const double severity : severities)
    if (!(severity >= least && severity <= most))
      throw std::invalid_argument("--severity '" + text + "': expected " + severity_text(least) + " to " +
                                  severity_text(most) + " for " + std::string(family.name) + " (" +
                                  std::string(family.severity) + ")");
  std::sort(severities.begin(), severities.end());
  return severities;
}

}  // namespace

std::vector<const StressFamily*> families_named(const std::string& names,
                                                const std::vector<StressFamily>& families) {
  std::vector<std::string> wanted;
  if (!names.empty()) wanted = list_of("--families", names);
  for (const std::string& name : wanted) {
    std::string valid;
    bool found = false;
    for (const StressFamily& family : families) {
      found |= family.name == name;
      valid += (valid.empty() ? "" : ", ") + std::string(family.name);
    }
    if (!found) throw std::invalid_argument("--families '" + name + "': expected some of " + valid);
  }
  std::vector<const StressFamily*> chosen;
  for (const StressFamily& family : families)
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), family.name) != wanted.end())
      chosen.push_back(&family);
  return chosen;
}

std::vector<StressPoint> points_of(const std::string& families, const std::string& severities,
                                   const std::string& sizes) {
  std::vector<StressPoint> points;
  for (const std::string& size : list_of("--size", sizes))
    for (const StressFamily* family : families_named(families, stress_families()))
      for (const double severity : severities_named(severities, *family))
        points.push_back({family, severity, size_named(size)});
  return points;
}

std::string severity_text(double severity) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", severity);
  std::string short_text = text;
  if (const std::size_t e = short_text.find('e'); e != short_text.npos) {
    if (short_text[e + 1] == '+') short_text.erase(e + 1, 1);
    const std::size_t digits = e + 1 + (short_text[e + 1] == '-');
    while (short_text[digits] == '0') short_text.erase(digits, 1);
  }
  return short_text;
}

namespace {

/// Whether `value` is worse than `known` where more is worse. NaN is the worst.
bool is_worse(double value, double known) { return !std::isnan(known) && !(value <= known); }

void add(StressRow& row, const StressVerdict& verdict, std::uint64_t seed) {
  StressVerdict& worst = row.worst;
  const bool first = row.seeds - row.failed == 1;
  if (first || is_worse(verdict.strict_normalised_error, worst.strict_normalised_error)) {
    worst.strict_normalised_error = verdict.strict_normalised_error;
    worst.worst_pixel = verdict.worst_pixel, row.worst_seed = seed;
  }
  for (const auto most : {&StressVerdict::normalised_error, &StressVerdict::normalised_depth_error,
                          &StressVerdict::max_abs, &StressVerdict::ambiguity, &StressVerdict::allowed})
    if (is_worse(verdict.*most, worst.*most)) worst.*most = verdict.*most;
  for (const auto least : {&StressVerdict::psnr_db, &StressVerdict::judged})
    if (is_worse(-(verdict.*least), -(worst.*least))) worst.*least = verdict.*least;
  worst.flips += verdict.flips;
}

StressRow row_of(const StressPoint& point, std::string_view renderer) {
  StressRow row;
  row.family = point.family->name, row.severity_label = point.family->severity;
  row.severity = point.severity;
  row.width = point.size.width, row.height = point.size.height;
  row.renderer = renderer;
  row.worst.psnr_db = std::numeric_limits<double>::infinity();
  return row;
}

Json json_of(const StressRow& r) {
  const RendererWords words(r.renderer);
  Json json{{"family", r.family},
            {"severity", r.severity},
            {"severity_label", r.severity_label},
            {"width", r.width},
            {"height", r.height},
            {"renderer", r.renderer},
            {"backend", words.backend},
            {"sort", words.sort},
            {"raster", words.raster},
            {"bounds", words.bounds},
            {"seeds", r.seeds},
            {"failed", r.failed},
            {"error", r.error.empty() ? Json() : Json(r.error)},
            {"strict_normalised_error", r.worst.strict_normalised_error},
            {"normalised_error", r.worst.normalised_error},
            {"normalised_depth_error", r.worst.normalised_depth_error},
            {"psnr_db", r.worst.psnr_db},
            {"max_abs", r.worst.max_abs},
            {"flips", r.worst.flips},
            {"ambiguity", r.worst.ambiguity},
            {"allowed", r.worst.allowed},
            {"judged", r.worst.judged},
            {"worst_seed", r.worst_seed},
            {"worst_pixel", r.worst.worst_pixel}};
  if (r.failed == r.seeds)  // nothing was drawn
    for (auto member = json.find("strict_normalised_error"); member != json.end(); ++member) *member = Json();
  return json;
}

}  // namespace

std::string to_json(const ResultHead& head, const std::vector<StressRow>& rows) {
  return document_of(head,
                     {{"rows", array_of(rows, [](const StressRow& row) { return text_of(json_of(row)); })}});
}

Frame draw(AnyRenderer& renderer, const StressCase& made) {
  renderer.set_scene(std::make_shared<const Scene>(made.scene));
  const Placement placement{.world_from_scene = made.world_from_scene, .clip = made.clip};
  renderer.place({&placement, 1});
  Frame frame;
  renderer.render(made.camera,
                  {.conventions = made.conventions, .background = made.background, .outputs = {true, true}},
                  frame);
  return frame;
}

Sweep::Sweep(std::vector<RendererEntry> entries, int seeds, int threads, bool scene_only)
    : seeds_(seeds), threads_(threads), scene_only_(scene_only) {
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
  const ConditionedFrame reference = render_conditioned(made, {seed, scene_only_}, threads_);
  for (std::size_t i = 0; i < subjects_.size(); ++i) {
    Subject& subject = subjects_[i];
    progress.start(std::string(point.family->name) + " " + severity_text(point.severity) + ": " +
                   subject.entry.name);
    ++rows[i].seeds;
    try {
      if (!subject.renderer) subject.renderer = subject.entry.make();
      add(rows[i],
          judge(reference, draw(*subject.renderer, made), exponent_representation_named(subject.entry.name)),
          seed);
    } catch (const std::exception& error) {
      if (rows[i].failed++ == 0) rows[i].error = "seed " + std::to_string(seed) + ": " + error.what();
      subject.renderer.reset();
    }
    progress.step();
  }
}

}  // namespace swiftgs::cli
