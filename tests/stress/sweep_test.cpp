// SPDX-License-Identifier: Apache-2.0
#include "stress/sweep.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <swiftgs/drivers/renderer_table.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/stress.hpp>
#include <swiftgs/swiftgs.hpp>

#include "cli/json_in.hpp"
#include "stress/stress.hpp"
#include "support/files.hpp"

namespace swiftgs {
namespace {

/// Adds a thousandth to every colour.
struct Off : PerPixel {
  static constexpr std::string_view name = "off-by-a-thousandth";
};

void rasterize(Serial& serial, Off, const RasterJob& job) {
  rasterize(serial, PerPixel{}, job);
  const FrameView& frame = job.views[0].frame;
  for (int y = 0; y < frame.height; ++y) {
    float* const row = static_cast<float*>(frame.colour.row(std::size_t(y)));
    for (int i = 0; i < 3 * frame.width; ++i) row[i] += 1e-3f;
  }
}

/// Leaves a value out that is no number.
struct NoNumber : PerPixel {
  static constexpr std::string_view name = "no-number";
};

void rasterize(Serial& serial, NoNumber, const RasterJob& job) {
  rasterize(serial, PerPixel{}, job);
  static_cast<float*>(job.views[0].frame.colour.row(0))[0] = std::numeric_limits<float>::quiet_NaN();
}

/// Throws on every other frame.
struct Throwing : PerPixel {
  static constexpr std::string_view name = "throwing";
};

int frames_of_throwing = 0;

void rasterize(Serial& serial, Throwing, const RasterJob& job) {
  if (frames_of_throwing++ % 2 == 0) throw std::runtime_error("no \"memory\"");
  rasterize(serial, PerPixel{}, job);
}

template <class... Rasters>
std::vector<RendererEntry> entries() {
  std::vector<RendererEntry> table;
  append_renderers<Serial>(table, TypeList<EarlySort>{}, TypeList<Rasters...>{}, TypeList<Ellipse>{});
  return table;
}

cli::StressOptions options_of(const std::string& family, const std::string& severity, int seeds) {
  cli::StressOptions options;
  options.families = family, options.severities = severity, options.seeds = seeds;
  return options;
}

std::string message_of(const cli::StressOptions& options, const std::vector<RendererEntry>& table) {
  try {
    cli::stress(options, table);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("stress: rows hold the worst of what judge says of each seed") {
  const struct {
    std::string name;  // in the file
    double StressVerdict::*number;
    bool least_is_worst = false;
  } numbers[] = {
      {"strict_normalised_error", &StressVerdict::strict_normalised_error},
      {"normalised_error", &StressVerdict::normalised_error},
      {"normalised_depth_error", &StressVerdict::normalised_depth_error},
      {"psnr_db", &StressVerdict::psnr_db, true},
      {"max_abs", &StressVerdict::max_abs},
      {"ambiguity", &StressVerdict::ambiguity},
      {"allowed", &StressVerdict::allowed},
      {"judged", &StressVerdict::judged, true},
  };
  const ImageSize size{32, 24};
  const std::vector<RendererEntry> table = entries<PerPixel, AxisShared<HalfSplit>, AxisShared<FloatSplit>>();
  const StressFamily& family = stress_families().back();
  cli::Progress progress(9);
  const auto rows = cli::Sweep(table, 3, 1).run({&family, 50, size}, progress);
  REQUIRE(rows.size() == table.size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    CAPTURE(table[i].name);
    const auto renderer = table[i].make();
    std::vector<StressVerdict> verdicts;
    std::uint64_t flips = 0, worst_seed = 1;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const StressCase made = family.make(50, seed, size);
      verdicts.push_back(judge(render_conditioned(made, {seed}), cli::draw(*renderer, made),
                               exponent_representation_named(table[i].name)));
      flips += verdicts.back().flips;
      if (verdicts.back().strict_normalised_error > verdicts[worst_seed - 1].strict_normalised_error)
        worst_seed = seed;
    }
    const auto json = nlohmann::json::parse(cli::to_json({}, {rows[i]})).at("rows").at(0);
    for (const auto& [name, number, least_is_worst] : numbers) {
      CAPTURE(name);
      double worst = verdicts[0].*number;
      for (const StressVerdict& verdict : verdicts)
        worst = least_is_worst ? std::min(worst, verdict.*number) : std::max(worst, verdict.*number);
      CHECK(rows[i].worst.*number == worst);
      CHECK(json.at(name) == worst);  // to the last digit
    }
    CHECK(rows[i].renderer == table[i].name);
    CHECK(rows[i].worst.flips == flips);
    CHECK(rows[i].worst_seed == worst_seed);
    CHECK(rows[i].worst.worst_pixel == verdicts[worst_seed - 1].worst_pixel);
    CHECK(rows[i].worst.max_abs > 0);
  }
}

TEST_CASE("stress: a renderer that is off by a thousandth is named and the exact one is not") {
  const cli::StressOptions options = options_of("needles", "max", 2);
  CHECK(message_of(options, entries<PerPixel>()) == "");
  const std::string message = message_of(options, entries<PerPixel, Off>());
  CAPTURE(message);
  CHECK(message.find("1 of 2 rows are above") != message.npos);
  CHECK(message.find("serial/early/off-by-a-thousandth/ellipse on needles at 1e10") != message.npos);
}

TEST_CASE("stress: a search names the renderer that is off by a thousandth and writes its errors") {
  test::TemporaryFolder place;
  cli::StressOptions options;
  options.families = "on-stops", options.search = 0.2, options.json = (place / "r.json").string();
  CHECK(message_of(options, entries<PerPixel>()) == "");
  const std::string message = message_of(options, entries<PerPixel, Off>());
  CAPTURE(message);
  CHECK(message.find("1 of 4 rows are above") != message.npos);
  CHECK(message.ends_with(" of serial/early/off-by-a-thousandth/ellipse on on-stops"));
  const auto rows = test::json_in(place / "r.json").at("rows");
  REQUIRE(rows.size() == 4);
  CHECK(rows[2].at("normalised_error") > 10);
  CHECK(rows[2].at("plane") == "colour");
  CHECK(message_of(options, entries<Throwing>()).ends_with("throwing/ellipse on on-stops: no \"memory\""));
}

TEST_CASE("stress: a frame with a value that is no number has an infinite normalised error") {
  const cli::StressOptions options = options_of("needles", "max", 1);
  const std::string message = message_of(options, entries<Off, NoNumber, PerPixel>());
  CAPTURE(message);
  CHECK(message.find("2 of 3 rows are above, the worst inf of serial/early/no-number/ellipse") !=
        message.npos);
  cli::Progress progress(1);
  const auto rows =
      cli::Sweep(entries<NoNumber>(), 2, 1).run({&stress_families().front(), 1e4, {}}, progress);
  const auto row = nlohmann::json::parse(cli::to_json({}, rows)).at("rows").at(0);
  CHECK(row.at("strict_normalised_error").is_null());
  CHECK(row.at("max_abs").is_null());
  CHECK(row.at("failed") == 0);
}

TEST_CASE("stress: a renderer that throws has a row with its message and the others go on") {
  test::TemporaryFolder place;
  cli::StressOptions options = options_of("needles", "100,1e4", 3);
  options.json = (place / "r.json").string();
  frames_of_throwing = 0;
  const std::string message = message_of(options, entries<Throwing, PerPixel>());
  CAPTURE(message);
  CHECK(message.find("failed in 2 of 4 rows") != message.npos);
  CHECK(message.ends_with("serial/early/throwing/ellipse on needles at 100, seed 1: no \"memory\""));
  const auto rows = test::json_in(place / "r.json").at("rows");
  REQUIRE(rows.size() == 4);
  CHECK(rows[0].at("failed") == 2);
  CHECK(rows[0].at("seeds") == 3);
  CHECK(rows[0].at("error") == "seed 1: no \"memory\"");
  CHECK(rows[0].at("worst_seed") == 2);
  CHECK(rows[1].at("failed") == 0);
  CHECK(rows[1].at("strict_normalised_error") <= 10);
  CHECK(rows[2].at("failed") == 1);

  frames_of_throwing = 0;
  options.seeds = 1, options.severities = "100";
  CHECK(message_of(options, entries<Throwing>()) != "");
  const auto row = test::json_in(place / "r.json").at("rows").at(0);
  for (const char* number : {"strict_normalised_error", "psnr_db", "max_abs", "ambiguity", "worst_seed"})
    CHECK(row.at(number).is_null());
}

}  // namespace swiftgs
