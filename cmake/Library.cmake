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
