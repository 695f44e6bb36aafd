// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mpi.h>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/mpi/ranks.hpp>

namespace swiftgs {

/// The processes of `comm`, by a copy of it, for programs that start and end MPI themselves. The last copy
/// of the ranks must be gone before MPI is ended. Collective. Throws `MpiError`.
SWIFTGS_API Ranks ranks_of(MPI_Comm comm);

}  // namespace swiftgs
