// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Frames that are hard for float arithmetic, and a judge of renderers on them. To test your own backends and
/// policies, draw each case of `stress_families()`, and `judge` the frame by `render_conditioned`.
/// `StressSearch` looks for worse frames.

#include <swiftgs/stress/families.hpp>
#include <swiftgs/stress/judge.hpp>
#include <swiftgs/stress/search.hpp>
