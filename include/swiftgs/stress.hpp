// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames that are hard on arithmetic, and how good a renderer is at them. For backends and policies of your
/// own too: draw each case of `stress_families()`, and `judge` the frame by `render_conditioned`.

#include <swiftgs/stress/families.hpp>
#include <swiftgs/stress/judge.hpp>
