// SPDX-License-Identifier: Apache-2.0
#include "view/resolution.hpp"

#include <doctest/doctest.h>

using swiftgs::cli::Resolution;

TEST_CASE("view resolution: half the size while moving and the whole size when still") {
  Resolution resolution;
  CHECK(resolution.due(0) == 1);
  resolution.drew(1, 0.1);
  CHECK(resolution.due(5) == std::nullopt);

  resolution.changed(10);
  CHECK(resolution.due(10) == 0.5);
  resolution.drew(0.5, 0.03);
  CHECK(resolution.due(10.1) == std::nullopt);
  resolution.changed(10.15);
  CHECK(resolution.due(10.2) == 0.5);
  resolution.drew(0.5, 0.03);
  CHECK(resolution.due(10.3) == std::nullopt);
  CHECK(resolution.due(10.36) == 1);
  resolution.drew(1, 0.1);
  CHECK(resolution.due(20) == std::nullopt);
}

TEST_CASE("view resolution: quick whole frames are drawn while moving") {
  Resolution resolution;
  resolution.drew(1, 0.01);
  resolution.changed(10);
  CHECK(resolution.due(10) == 1);
  resolution.drew(1, 0.1);
  resolution.changed(10.1);
  CHECK(resolution.due(10.1) == 0.5);
}
