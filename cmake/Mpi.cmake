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

# Devices of ranks exchange through NCCL where its header and its library are. Its Python package has both, and no name
# that a linker looks for: nvidia/nccl in the folder of packages.
set(SWIFTGS_NCCL_ROOT "" CACHE PATH "Folder with NCCL's include/nccl.h and lib/libnccl.so.2, beside the usual places")
set(swiftgs_has_nccl OFF)
if(SWIFTGS_BUILD_MPI AND SWIFTGS_BUILD_CUDA)
  find_path(SWIFTGS_NCCL_INCLUDE nccl.h HINTS "${SWIFTGS_NCCL_ROOT}" PATH_SUFFIXES include)
  find_library(SWIFTGS_NCCL_LIBRARY NAMES nccl libnccl.so.2 HINTS "${SWIFTGS_NCCL_ROOT}" PATH_SUFFIXES lib)
  mark_as_advanced(SWIFTGS_NCCL_INCLUDE SWIFTGS_NCCL_LIBRARY)
  if(SWIFTGS_NCCL_INCLUDE AND SWIFTGS_NCCL_LIBRARY)
    set(swiftgs_has_nccl ON)
  elseif(SWIFTGS_NCCL_ROOT)
    message(FATAL_ERROR "SWIFTGS_NCCL_ROOT: expected include/nccl.h and lib/libnccl.so.2 in ${SWIFTGS_NCCL_ROOT}")
  endif()
endif()
