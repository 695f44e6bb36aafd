// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include <swiftgs/cpu.hpp>

namespace swiftgs {

/// Evaluates the colours of the Gaussians `ids` in this view, and puts each with its depth; a splat whose
/// colour is not finite loses its opacity. All arrays have `count` elements.
void shade_splats(const ViewConstants& constants, const SceneView& scene, const std::uint32_t* ids,
                  const float* depths, std::size_t count, SplatShape* shapes, SplatColour* colours);

}  // namespace swiftgs
