// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string_view>

namespace swiftgs {

/// Whether a launcher of MPI started this process, by what it left in the environment. A program that asks
/// first need not start MPI where it is alone.
inline bool started_by_launcher() {
  // Variables of Open MPI, and of PMIx and PMI, which MPICH, Intel MPI and Slurm set.
  constexpr std::array names{"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_SIZE"};
  return std::any_of(names.begin(), names.end(), [](const char* name) { return std::getenv(name); });
}

/// Whether a launcher of MPI started this process and others. True where the launcher does not tell how many
/// processes it started.
inline bool started_with_others() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"})
    if (const char* count = std::getenv(name)) return started_by_launcher() && std::string_view(count) != "1";
  return started_by_launcher();
}

/// Whether the launcher started other processes before this one.
inline bool started_behind_others() {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"})
    if (const char* rank = std::getenv(name)) return started_with_others() && std::string_view(rank) != "0";
  return false;
}

}  // namespace swiftgs
