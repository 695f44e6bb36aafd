// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/io/scene_file.hpp>

#include "progress_meter.hpp"
#include "scenes.hpp"
#include "support/files.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

namespace {

/// What a `Progress` was told.
struct Listener {
  std::vector<double> told{};

  Progress progress() {
    return [this](double part) {
      told.push_back(part);
      return true;
    };
  }

  void check_whole() const {
    REQUIRE(told.size() >= 2);
    CHECK(told.front() == 0);
    CHECK(told.back() == 1);
    for (std::size_t i = 1; i < told.size(); ++i) REQUIRE(told[i] >= told[i - 1]);
  }
};

void check_progress_of_all_formats(const Scene& scene) {
  const TemporaryFolder folder;
  for (const std::string name : {"a.ply", "a.compressed.ply", "a.spz", "a.sog", "a.splat"}) {
    CAPTURE(name);
    Listener writing, reading;
    write_scene(folder / name, scene, {.progress = writing.progress()});
    writing.check_whole();
    read_scene(folder / name, {.progress = reading.progress()});
    reading.check_whole();
  }
  Listener writing;
  write_scene(folder / "a.spz", scene, {.spz_version = 3, .progress = writing.progress()});
  writing.check_whole();
}

}  // namespace

TEST_CASE("progress: every writer and reader goes from 0 to 1 and never back") {
  for (const int degree : {0, 3}) check_progress_of_all_formats(some_scene(3000, degree));
}

TEST_CASE("progress: harmonics so small that their squares are no floats do not turn it back") {
  Scene scene = some_scene(1000, 1);
  for (float& value : scene.sh_rest) value *= 1e-22f;
  for (const float factor : {1.0f, 0.5f, 0.25f, 0.125f}) {
    Scene smaller = scene;
    for (float& value : smaller.sh_rest) value *= factor;
    check_progress_of_all_formats(smaller);
  }
}

TEST_CASE("progress: steps that overlap or round do not turn it back") {
  Listener listener;
  const Progress progress = listener.progress();
  const io::ProgressMeter meter(progress, "a");
  meter.report(0);
  for (int i = 0; i < 300; ++i) {
    const io::ProgressMeter step = meter.step(i / 300.0, (i + 1) / 300.0);
    for (int j = 0; j < 7; ++j) step.step(j / 7.0, (j + 1) / 7.0).report(1);
    step.step(0, 0.5).report(0);
  }
  meter.report(1);
  listener.check_whole();
}
