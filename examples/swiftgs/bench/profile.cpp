// SPDX-License-Identifier: Apache-2.0
#include "bench/profile.hpp"

#include <cstdio>
#include <memory>
#include <string>

#if defined(SWIFTGS_HAS_CUDA)
#include <cuda_profiler_api.h>

#include <swiftgs/cuda/check.hpp>
#endif

#if defined(SWIFTGS_HAS_VULKAN)
#include <swiftgs/vulkan.hpp>
#endif

#include "bench/measure.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

Mark mark_of(const AnyRenderer& renderer) {
#if defined(SWIFTGS_HAS_CUDA)
  if (RendererWords(renderer.name()).backend == "cuda")
    return [](bool on) {
      if (on)
        check_cuda(cudaProfilerStart(), "cudaProfilerStart");
      else
        check_cuda(cudaProfilerStop(), "cudaProfilerStop");
    };
#else
  static_cast<void>(renderer);
#endif
  return [](bool) {};
}

void print_frames(const AnyRenderer& renderer, const Session& session) {
  for (const View& view : session.views)
    std::printf("%s: %s, %zu Gaussians, view %s, %dx%d, %s\n", std::string(renderer.name()).c_str(),
                session.scene.scene.c_str(), session.scene.gaussians, view.name.c_str(), view.camera.width,
                view.camera.height, session.conventions.c_str());
  std::fflush(stdout);
}

/// Draws each view once more by `Vulkan`, and prints the time of its kernels.
void print_kernels(AnyRenderer& renderer, const Session& session) {
#if defined(SWIFTGS_HAS_VULKAN)
  auto* const vulkan = dynamic_cast<BoundRenderer<Vulkan>*>(&renderer);
  if (!vulkan) return;
  for (const View& view : session.views) {
    std::printf("%s: kernels, us:", view.name.c_str());
    for (const auto& [name, ms] :
         vulkan->backend().profile([&] { renderer.render_resident(view.camera, session.settings); }))
      std::printf(" %s %.1f", std::string(name).c_str(), 1000 * ms);
    std::printf("\n");
  }
#else
  static_cast<void>(renderer), static_cast<void>(session);
#endif
}

}  // namespace

void draw_marked(AnyRenderer& renderer, const Session& session, const Mark& mark) {
  for (const View& view : session.views) adapt(renderer, {&view.camera, 1}, session.settings);
  mark(true);
  for (const View& view : session.views) renderer.render_resident(view.camera, session.settings);
  mark(false);
}

void profile(const std::vector<RendererEntry>& entries, const Session& session, Progress& progress) {
  for (const RendererEntry& entry : entries) {
    progress.start(session.scene.scene + " " + entry.name);
    const std::unique_ptr<AnyRenderer> renderer = entry.make();
    renderer->set_scene(session.gaussians, session.harmonics);
    draw_marked(*renderer, session, mark_of(*renderer));
    progress.clear();
    print_frames(*renderer, session);
    print_kernels(*renderer, session);
    for (std::size_t view = 0; view < session.views.size(); ++view) progress.step();
  }
}

}  // namespace swiftgs::cli
