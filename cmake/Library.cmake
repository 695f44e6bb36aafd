# SPDX-License-Identifier: Apache-2.0

# swiftgs_library(TARGET): what every compiled library of ours is, static or shared.
#
# Code that can be part of a shared library, symbols that only `SWIFTGS_API` exports, a name that changes with each minor
# version until 1.0, and neighbours that are found beside it, wherever it is installed.
function(swiftgs_library target)
  if(NOT DEFINED CMAKE_POSITION_INDEPENDENT_CODE)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  endif()
  set_target_properties(${target} PROPERTIES
    CXX_VISIBILITY_PRESET hidden CUDA_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    DEFINE_SYMBOL "" VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  if(NOT DEFINED CMAKE_INSTALL_RPATH AND NOT APPLE)
    set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN")
  endif()
endfunction()

# swiftgs_vectors(TARGET [disabled]): TARGET has kernels that Highway compiles for each kind of vector but `disabled`.
function(swiftgs_vectors target)
  target_link_libraries(${target} PRIVATE hwy::hwy)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
    # NEON alone, on processors with SVE too. Kernels count lanes when they are compiled and have structs of vectors,
    # and vectors of SVE allow neither. Without a choice at run time Highway leaves out an attribute of functions that gcc
    # does not give to constructors of such structs.
    target_compile_definitions(${target} PRIVATE
      "HWY_DISABLED_TARGETS=(HWY_SVE|HWY_SVE2|HWY_SVE_256|HWY_SVE2_128)" TOOLCHAIN_MISS_SYS_AUXV_H)
  elseif(ARGN)
    target_compile_definitions(${target} PRIVATE HWY_DISABLED_TARGETS=${ARGN})
  endif()
endfunction()
