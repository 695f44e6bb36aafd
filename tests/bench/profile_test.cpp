// SPDX-License-Identifier: Apache-2.0
#include "bench/profile.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>

#include "bench/scripted_renderer.hpp"

using namespace swiftgs;
using namespace swiftgs::cli;
using swiftgs::test::ScriptedRenderer;

namespace {

/// The frames of three views and the marks around them, in their order.
std::vector<std::string> frames_and_marks(const std::string& renderer) {
  std::vector<std::string> calls;
  ScriptedRenderer scripted(
      renderer, [](int) { return 1.0; }, &calls);
  Session session;
  session.views.assign(3, cli::View{builtin_camera(), "front"});
  draw_marked(scripted, session, [&](bool on) { calls.emplace_back(on ? "begin" : "end"); });
  return calls;
}

}  // namespace

TEST_CASE("bench profile: a profiler sees each view once and after all of them were drawn") {
  const std::string name = "serial/early/per-pixel/ellipse";
  CHECK(frames_and_marks(name) ==
        std::vector<std::string>{name, name, name, "begin", name, name, name, "end"});
}

TEST_CASE("bench profile: an adaptive sort has frames to decide before the mark and none after") {
  const std::vector<std::string> calls = frames_and_marks("serial/adaptive/per-pixel/ellipse");
  const auto begin = std::find(calls.begin(), calls.end(), "begin");
  CHECK(begin - calls.begin() >= 3 * 10);
  CHECK(calls.end() - begin == 5);
}
