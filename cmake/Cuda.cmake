# SPDX-License-Identifier: Apache-2.0

# Decides whether swiftgs::cuda is built, and enables its language. C++20 in kernels needs a toolkit of version 13.
set(swiftgs_cuda_version 13)

if(NOT DEFINED SWIFTGS_BUILD_CUDA)
  # A path is not a boolean that option() understands, and nvcc may be outside of PATH, where only CUDAToolkit looks.
  find_package(CUDAToolkit ${swiftgs_cuda_version} QUIET)
  set(swiftgs_cuda_found OFF)
  if(CUDAToolkit_FOUND AND CUDAToolkit_NVCC_EXECUTABLE)
    if(NOT DEFINED ENV{CUDACXX})
      set(ENV{CUDACXX} "${CUDAToolkit_NVCC_EXECUTABLE}")
    endif()
    include(CheckLanguage)
    check_language(CUDA)
    # What CUDACXX names need not belong to the toolkit that was found.
    if(CMAKE_CUDA_COMPILER)
      execute_process(COMMAND "${CMAKE_CUDA_COMPILER}" --version OUTPUT_VARIABLE nvcc_says ERROR_QUIET)
      if(nvcc_says MATCHES "release ([0-9.]+)" AND CMAKE_MATCH_1 VERSION_GREATER_EQUAL swiftgs_cuda_version)
        set(swiftgs_cuda_found ON)
      endif()
    endif()
  endif()
  if(NOT swiftgs_cuda_found)
    message(STATUS "No nvcc ${swiftgs_cuda_version} or newer that works here: swiftgs::cuda is left out")
  endif()
endif()
option(SWIFTGS_BUILD_CUDA "Build swiftgs::cuda (needs nvcc 13 or newer)" ${swiftgs_cuda_found})

if(SWIFTGS_BUILD_CUDA)
  include(cmake/NativeGpus.cmake)
  swiftgs_native_gpus(swiftgs_gpus_here)
  if(CMAKE_CUDA_ARCHITECTURES STREQUAL "native")
    set(CMAKE_CUDA_ARCHITECTURES 90)  # an H100
    if(swiftgs_gpus_here)
      set(CMAKE_CUDA_ARCHITECTURES "${swiftgs_gpus_here}")
    endif()
    message(STATUS "GPUs to compile for: ${CMAKE_CUDA_ARCHITECTURES}")
  endif()
  # Not in the cache, where a project that embeds this one would find what is meant for it alone.
  set(swiftgs_architectures_chosen ON)
  if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES AND NOT DEFINED ENV{CUDAARCHS})
    set(swiftgs_architectures_chosen OFF)
    set(CMAKE_CUDA_ARCHITECTURES 75)  # an nvcc that is too old knows it as well, and can be named below
  endif()
  enable_language(CUDA)
  if(NOT CMAKE_CUDA_COMPILER_ID STREQUAL "NVIDIA" OR
     CMAKE_CUDA_COMPILER_VERSION VERSION_LESS swiftgs_cuda_version)
    message(FATAL_ERROR "SWIFTGS_BUILD_CUDA: expected nvcc ${swiftgs_cuda_version} or newer; found "
                        "${CMAKE_CUDA_COMPILER_ID} ${CMAKE_CUDA_COMPILER_VERSION}, ${CMAKE_CUDA_COMPILER}")
  endif()
  if(NOT swiftgs_architectures_chosen)
    # Machine code for every kind of GPU that nvcc 13 knows; one minor version runs the code of those before it. And
    # code that drivers can translate for what comes later.
    set(CMAKE_CUDA_ARCHITECTURES 75-real 80-real 86-real 89-real 90-real 100-real 110-real 120)
  endif()
  find_package(CUDAToolkit ${swiftgs_cuda_version} REQUIRED)
endif()

string(COMPARE NOTEQUAL "${swiftgs_gpus_here}" "" gpu_is_here)
cmake_dependent_option(SWIFTGS_TEST_ON_GPU "Build the tests that need a GPU: they take as long to compile as all others"
  ${gpu_is_here} "SWIFTGS_BUILD_CUDA;SWIFTGS_BUILD_TESTS" OFF)
# To ask whether there is a GPU takes memory of it: tests that ask run one at a time, and beside none on the GPU.
set(swiftgs_gpu_lock)
if(swiftgs_gpus_here OR SWIFTGS_TEST_ON_GPU)
  set(swiftgs_gpu_lock RESOURCE_LOCK gpu)
endif()

# swiftgs::gl needs OpenGL's header, and nothing of its library.
find_path(SWIFTGS_GL_INCLUDE GL/gl.h)
mark_as_advanced(SWIFTGS_GL_INCLUDE)
cmake_dependent_option(SWIFTGS_BUILD_GL "Build swiftgs::gl" ON "SWIFTGS_BUILD_CUDA;SWIFTGS_GL_INCLUDE" OFF)
if(SWIFTGS_BUILD_CUDA AND NOT SWIFTGS_GL_INCLUDE)
  message(STATUS "No GL/gl.h here (package libgl-dev): swiftgs::gl is left out")
endif()
