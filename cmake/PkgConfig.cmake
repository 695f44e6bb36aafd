# SPDX-License-Identifier: Apache-2.0

# Files for pkg-config, one a library, for builds without CMake. A static library names what it rests on, so that
# `pkg-config --libs` is enough; a shared one brings it.
file(RELATIVE_PATH to_prefix "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(REGEX REPLACE "/$" "" to_prefix "${to_prefix}")

# swiftgs_pkg_config(name target description [REQUIRES packages...] [VARIABLE line] [CFLAGS flags...] [LIBS flags...])
#
# LIBS: for what a static library rests on and has no such file.
function(swiftgs_pkg_config name target description)
  cmake_parse_arguments(PARSE_ARGV 3 arg "" "VARIABLE" "REQUIRES;CFLAGS;LIBS")
  set(needed ${arg_REQUIRES})
  list(JOIN arg_CFLAGS " " cflags)
  get_target_property(type ${target} TYPE)
  set(libs)
  if(NOT type STREQUAL INTERFACE_LIBRARY)
    get_target_property(output ${target} OUTPUT_NAME)
    if(NOT output)
      set(output ${target})
    endif()
    set(libs "-L\${libdir} -l${output}")
  endif()
  if(type STREQUAL STATIC_LIBRARY)
    list(JOIN arg_LIBS " " rests_on)
    string(APPEND libs " ${rests_on} -pthread")
  else()
    list(FILTER needed INCLUDE REGEX "^swiftgs")
  endif()
  list(JOIN needed " " requires)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/swiftgs.pc.in" "${PROJECT_BINARY_DIR}/pkgconfig/${name}.pc" @ONLY)
  install(FILES "${PROJECT_BINARY_DIR}/pkgconfig/${name}.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
    COMPONENT dev)
endfunction()

swiftgs_pkg_config(swiftgs-core swiftgs_core "Headers of SwiftGS, which renders 3D Gaussian splatting")
swiftgs_pkg_config(swiftgs-reference swiftgs_reference "The float64 reference of SwiftGS" REQUIRES swiftgs-core)
swiftgs_pkg_config(swiftgs-builtin swiftgs_builtin "The built-in scene of SwiftGS" REQUIRES swiftgs-core)
set(all swiftgs-builtin)
if(TARGET swiftgs_cpu)
  swiftgs_pkg_config(swiftgs-cpu swiftgs_cpu "The backend of SwiftGS for processors" REQUIRES swiftgs-core tbb libhwy)
  list(APPEND all swiftgs-cpu)
endif()
if(TARGET swiftgs_io)
  set(needs swiftgs-core zlib libpng libjpeg libzstd libwebp libzip libhwy)
  get_property(has_openexr GLOBAL PROPERTY SWIFTGS_HAS_OPENEXR)
  if(has_openexr)
    list(APPEND needs OpenEXR)
  endif()
  swiftgs_pkg_config(swiftgs-io swiftgs_io "Readers and writers of SwiftGS" REQUIRES ${needs})
  list(APPEND all swiftgs-io)
endif()
if(TARGET swiftgs_vulkan)
  swiftgs_pkg_config(swiftgs-vulkan swiftgs_vulkan "The backend of SwiftGS for GPUs by Vulkan" REQUIRES swiftgs-core
    LIBS -ldl)
  list(APPEND all swiftgs-vulkan)
endif()
if(TARGET swiftgs_cuda)
  # The toolkit has no files for pkg-config that are always there: name the place of the one that was built with. Where it
  # is another, `pkg-config --define-variable=cuda_headers=...` says so.
  list(GET CUDAToolkit_INCLUDE_DIRS 0 cuda_headers)
  swiftgs_pkg_config(swiftgs-cuda swiftgs_cuda "The backend of SwiftGS for NVIDIA GPUs" REQUIRES swiftgs-core
    VARIABLE "cuda_headers=${cuda_headers}" CFLAGS "-I\${cuda_headers}" LIBS "-L${CUDAToolkit_LIBRARY_DIR}" -lcudart_static -ldl -lrt)
  list(APPEND all swiftgs-cuda)
  swiftgs_pkg_config(swiftgs-cuda-vulkan swiftgs_cuda_vulkan "Frames of SwiftGS on NVIDIA GPUs in memory of Vulkan"
    REQUIRES swiftgs-cuda)
  if(TARGET swiftgs_gl)
    swiftgs_pkg_config(swiftgs-gl swiftgs_gl "Frames of SwiftGS in memory of OpenGL" REQUIRES swiftgs-cuda)
  endif()
endif()
swiftgs_pkg_config(swiftgs swiftgs "All of SwiftGS, and its table of renderers" REQUIRES ${all})
if(TARGET swiftgs_c)
  swiftgs_pkg_config(swiftgs-c swiftgs_c "The C interface of SwiftGS")
endif()
