// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>

#include <doctest/doctest.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/scene_arrays.hpp>

#include "support/skip.hpp"

#if defined(__linux__)
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#ifndef MADV_COLLAPSE
#define MADV_COLLAPSE 25
#endif

namespace {

int moves = 0;  ///< arrays that the system was asked to move to large pages at once

}  // namespace

extern "C" int madvise(void* memory, size_t bytes, int advice) noexcept {
  moves += advice == MADV_COLLAPSE;
  return int(syscall(SYS_madvise, memory, bytes, advice));
}
#endif

using namespace swiftgs;

TEST_CASE("cpu: an upload moves arrays to large pages only if asked to") {
#if defined(__linux__)
  const Cpu cpu;
  const auto scene = std::make_shared<const Scene>(make_builtin_scene(400'000));
  const SceneArrays arrays{.count = scene->size(),
                           .means = {&scene->means[0].x},
                           .scales = {&scene->scales[0].x},
                           .rotations = {&scene->rotations[0].w},
                           .opacities = {scene->opacities.data()},
                           .sh0 = {&scene->sh0[0].x},
                           .sh_rest = {scene->sh_rest.data()},
                           .sh_degree = scene->sh_degree};
  std::optional<Cpu::SceneOn> copy;
  moves = 0;
  (void)cpu.upload(scene);
  copy.emplace(cpu.upload(arrays, copy));
  copy.emplace(cpu.upload(arrays, copy));
  CHECK(moves == 0);
  (void)cpu.upload(scene, LargePages::now);
  CHECK(moves == 5);  // the opacities fill no page
#else
  test::skip("large pages are advised on Linux alone");
#endif
}
