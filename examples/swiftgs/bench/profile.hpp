// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include <swiftgs/any_renderer.hpp>

#include "bench/runner.hpp"
#include "notes.hpp"

namespace swiftgs::cli {

/// Begins what a profiler is to record if `on`, else ends it.
using Mark = std::function<void(bool on)>;

/// Draws each view of `session` once with `renderer`, which has the scene, between two calls of `mark`.
/// Before them, draws all views until buffers have their sizes and an adaptive sort has decided.
void draw_marked(AnyRenderer& renderer, const Session& session, const Mark& mark);

/// Does this with each of `entries`, one after the other, and prints a line for each marked frame. Marks
/// frames of `Cuda` by the calls that profilers of CUDA look for. `Vulkan` draws each view once more, and a
/// line has the times of its kernels.
void profile(const std::vector<RendererEntry>& entries, const Session& session, Progress& progress);

}  // namespace swiftgs::cli
