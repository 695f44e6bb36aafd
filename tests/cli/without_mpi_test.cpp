// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <stdexcept>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "draw/team.hpp"

namespace {

using Variables = std::vector<std::pair<const char*, const char*>>;  ///< names and values

/// What the tool does in an environment of these variables alone.
int run_with(const Variables& variables) {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK",
                           "PMI_SIZE", "SLURM_STEP_NUM_TASKS", "SLURM_PROCID"})
    unsetenv(name);
  for (const auto& [name, value] : variables) setenv(name, value, 1);
  return swiftgs::cli::Team::run(0, nullptr, [] { return 7; });
}

}  // namespace

TEST_CASE("cli: a build without MPI refuses to be one of several processes of a launcher") {
  const std::vector<Variables> launched{{{"OMPI_COMM_WORLD_SIZE", "2"}, {"PMIX_RANK", "0"}},
                                        {{"PMI_RANK", "0"}, {"PMI_SIZE", "16"}},
                                        {{"PMIX_RANK", "0"}, {"SLURM_STEP_NUM_TASKS", "4"}},
                                        {{"PMIX_RANK", "0"}},
                                        {{"OMPI_COMM_WORLD_SIZE", "2"}}};
  for (const Variables& variables : launched)
    CHECK_THROWS_WITH_AS(run_with(variables), doctest::Contains("expected a build with SWIFTGS_BUILD_MPI"),
                         std::runtime_error);
}

TEST_CASE("cli: a build without MPI refuses once for all processes of a launcher") {
  CHECK(run_with({{"OMPI_COMM_WORLD_SIZE", "2"}, {"OMPI_COMM_WORLD_RANK", "1"}}) == 1);
  CHECK(run_with({{"PMI_RANK", "15"}, {"PMI_SIZE", "16"}}) == 1);
  CHECK(run_with({{"PMIX_RANK", "3"}, {"SLURM_STEP_NUM_TASKS", "4"}}) == 1);
}

TEST_CASE("cli: a build without MPI works alone and as the only process of a launcher") {
  CHECK(run_with({}) == 7);
  CHECK(run_with({{"OMPI_COMM_WORLD_SIZE", "1"}, {"PMIX_RANK", "0"}}) == 7);
  CHECK(run_with({{"PMIX_RANK", "0"}, {"SLURM_STEP_NUM_TASKS", "1"}}) == 7);
  // A shell within a job is no launcher of MPI.
  CHECK(run_with({{"SLURM_PROCID", "3"}, {"SLURM_STEP_NUM_TASKS", "4"}}) == 7);
}
