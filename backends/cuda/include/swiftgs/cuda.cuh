// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Definitions behind `<swiftgs/cuda.hpp>` for code that nvcc compiles: loops over functors, bounds and
/// rasterizers of your own. Compile with `-fmad=false` what instantiates `project` or `emit_instances`: tiles
/// are counted by one kernel and emitted by another, and both must round alike.

#include <swiftgs/cuda.hpp>
#include <swiftgs/cuda/for_each.cuh>
#include <swiftgs/cuda/instances.cuh>
#include <swiftgs/cuda/project.cuh>
