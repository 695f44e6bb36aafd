// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <swiftgs/clip.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/similarity.hpp>

namespace swiftgs::test {

/// A placed scene, on the host.
struct Placed {
  Scene scene;
  Similarity pose{};
  float opacity = 1;
  Clip clip{};
};
using List = std::vector<Placed>;

}  // namespace swiftgs::test
