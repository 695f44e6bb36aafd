// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One frame over the ranks of MPI. <swiftgs/mpi/comm.hpp> is left out, which alone needs the headers of MPI.

#include <swiftgs/mpi/renderer.hpp>
#include <swiftgs/tools/scene_part.hpp>
