# SPDX-License-Identifier: Apache-2.0

# Decides whether swiftgs::mpi is built.
if(NOT DEFINED SWIFTGS_BUILD_MPI)
  find_package(MPI QUIET COMPONENTS CXX)
  if(NOT MPI_CXX_FOUND)
    message(STATUS "No MPI here: swiftgs::mpi is left out")
  endif()
endif()
option(SWIFTGS_BUILD_MPI "Build swiftgs::mpi (needs an MPI, such as Open MPI or MPICH)" ${MPI_CXX_FOUND})
if(SWIFTGS_BUILD_MPI)
  find_package(MPI REQUIRED COMPONENTS CXX)
endif()
