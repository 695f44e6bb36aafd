// SPDX-License-Identifier: Apache-2.0

// Captures of which each rank reads its own part have the bits of one process.
#include "scenes/captures.hpp"

#include <filesystem>

#include <doctest/doctest.h>

#include "mpi/compare.hpp"

using namespace swiftgs;
using namespace swiftgs::test;

TEST_CASE("mpi captures: each policy draws the bits of one process") {
  const std::filesystem::path folder = capture_or_skip("fox");
  if (folder.empty()) return;
  const TrainedCapture capture = read_capture(folder);
  const Scene part = load_scene(find_capture(folder).scene, {.part = own_part()});
  compare_every_policy(*capture.scene, part,
                       {scaled(capture.cameras[0], 0.3), scaled(capture.cameras.back(), 0.2)});
}
