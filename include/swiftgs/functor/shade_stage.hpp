// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/frame_plan.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/project/colour.hpp>
#include <swiftgs/project/project.hpp>

namespace swiftgs {

/// Evaluates the colour of splat i: the only place that reads spherical harmonics.
template <class Scenes>
struct SWIFTGS_API ShadeSplats {
  const View* views;
  Scenes scenes;
  SplatsView splats;
  SplatColour* colours;
  std::uint32_t* colourless;

  SWIFTGS_HD void operator()(std::size_t i) const {
    const auto seen = scenes.see(views[splats.view(i)].camera, splats.gaussians[i]);
    const float depth = drawn_depth(seen.camera, seen.scene, seen.i, splats.depths[i]);
    SplatColour colour = splat_colour(project_colour(seen.camera, seen.scene, seen.i), depth);
    if (is_colourless(colour)) colour = large_splat_colour(seen.camera, seen.scene, seen.i, depth);
    if (is_colourless(colour)) note_colourless();
    colours[i] = tinted(colour, seen.tint);
  }

 private:
  /// Several loops may run at once, and each may write.
  SWIFTGS_HD void note_colourless() const {
#if defined(__CUDA_ARCH__)
    *colourless = 1;
#else
    std::atomic_ref<std::uint32_t>(*colourless).store(1, std::memory_order_relaxed);
#endif
  }
};

/// Sets one word to 0.
struct SWIFTGS_API ClearWord {
  std::uint32_t* word;
  SWIFTGS_HD void operator()(std::size_t) const { *word = 0; }
};

/// Evaluates the colours of `splats`, which were projected by `plan`. The sort does not read them: a backend
/// may run this beside it.
template <FunctorBackend B>
Shading<B> shade(B& b, const FramePlan& plan, const Splats<B>& splats, Colours<B>& colours) {
  colours.each.reset(splats.count), colours.colourless.reset(1);
  b.for_each(1, ClearWord{colours.colourless.data()});
  with_scenes(plan.scenes, [&]<class Scenes>(const Scenes& scenes) {
    b.for_each(splats.count, ShadeSplats<Scenes>{plan.views.reachable(), scenes, splats.view(),
                                                 colours.each.data(), colours.colourless.data()});
  });
  return Shading<B>({{colours.each.data(), splats.count}, colours.colourless.data()});
}

}  // namespace swiftgs
