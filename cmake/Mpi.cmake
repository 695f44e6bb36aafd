# SPDX-License-Identifier: Apache-2.0

# Decides whether swiftgs::mpi is built.
if(NOT DEFINED SWIFTGS_BUILD_MPI OR SWIFTGS_BUILD_MPI STREQUAL "AUTO")
  find_package(MPI QUIET COMPONENTS CXX)
endif()
swiftgs_auto_option(SWIFTGS_BUILD_MPI "Build swiftgs::mpi (needs an MPI, such as Open MPI or MPICH)" MPI_CXX_FOUND)
if(SWIFTGS_BUILD_MPI)
  find_package(MPI REQUIRED COMPONENTS CXX)
endif()

# Devices of ranks exchange through NCCL where its header is. Its library is loaded when ranks first ask for it.
set(SWIFTGS_NCCL_ROOT "" CACHE PATH "Folder with NCCL's include/nccl.h, beside the usual places")
set(swiftgs_has_nccl OFF)
if(SWIFTGS_BUILD_MPI AND SWIFTGS_BUILD_CUDA)
  # Anew each time: another root may have been named.
  unset(SWIFTGS_NCCL_INCLUDE CACHE)
  find_path(SWIFTGS_NCCL_INCLUDE nccl.h HINTS "${SWIFTGS_NCCL_ROOT}/include" PATHS ${CUDAToolkit_INCLUDE_DIRS})
  mark_as_advanced(SWIFTGS_NCCL_INCLUDE)
  if(SWIFTGS_NCCL_INCLUDE)
    set(swiftgs_has_nccl ON)
  endif()
  if(SWIFTGS_NCCL_ROOT AND NOT EXISTS "${SWIFTGS_NCCL_ROOT}/include/nccl.h")
    message(FATAL_ERROR "SWIFTGS_NCCL_ROOT: expected include/nccl.h in ${SWIFTGS_NCCL_ROOT}")
  endif()
endif()
