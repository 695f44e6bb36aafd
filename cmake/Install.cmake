# SPDX-License-Identifier: Apache-2.0
include(CMakePackageConfigHelpers)
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/swiftgs")

include(cmake/PkgConfig.cmake)
install(FILES LICENSE DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT licence)  # packages have one each

# One export a component, so that find_package(swiftgs COMPONENTS core) asks for GLM alone.
set(swiftgs_components)
foreach(component IN ITEMS core builtin reference cpu cuda gl cuda_vulkan vulkan io pages mpi swiftgs c)
  set(target swiftgs_${component})
  if(component STREQUAL swiftgs)
    set(target swiftgs)
  endif()
  if(NOT TARGET ${target})
    continue()
  endif()
  list(APPEND swiftgs_components ${component})
  set(headers FILE_SET HEADERS COMPONENT dev)
  if(component STREQUAL swiftgs)
    set(headers)
  endif()
  # What a program loads: C apart, whose interface outlives those of C++, and kernels apart, which are large.
  set(loaded runtime)
  if(component STREQUAL c)
    set(loaded c)
  elseif(component MATCHES "^(cuda|gl|cuda_vulkan)$")
    set(loaded cuda)
  endif()
  install(TARGETS ${target} EXPORT swiftgs-${component}
    LIBRARY COMPONENT ${loaded} NAMELINK_COMPONENT dev ARCHIVE COMPONENT dev ${headers})
  if(component STREQUAL cuda)
    install(TARGETS swiftgs_cuda_kernels EXPORT swiftgs-cuda)
  elseif(component STREQUAL vulkan)  # shaders of policies are compiled where programs are
    install(FILES backends/vulkan/swiftgsShaders.cmake DESTINATION "${package_dir}" COMPONENT dev)
    install(DIRECTORY backends/vulkan/shaders DESTINATION "${package_dir}" COMPONENT dev)
  endif()
  install(EXPORT swiftgs-${component} NAMESPACE swiftgs:: DESTINATION "${package_dir}" COMPONENT dev)

  # A static library hands its private dependencies on to whoever links it.
  set(dependencies_of_core glm)
  set(dependencies_of_builtin)
  set(dependencies_of_reference Threads)
  set(dependencies_of_cpu)
  set(dependencies_of_cuda "CUDAToolkit ${swiftgs_cuda_version}")
  set(dependencies_of_gl)
  set(dependencies_of_cuda_vulkan)
  set(dependencies_of_vulkan)
  set(dependencies_of_io)
  set(dependencies_of_pages)
  set(dependencies_of_mpi MPI)
  set(dependencies_of_c)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL STATIC_LIBRARY)
    list(APPEND dependencies_of_cpu TBB hwy)
    list(APPEND dependencies_of_io Threads ZLIB PNG JPEG zstd WebP libzip hwy)
    list(APPEND dependencies_of_pages Threads)
    get_property(has_openexr GLOBAL PROPERTY SWIFTGS_HAS_OPENEXR)
    if(has_openexr)
      list(APPEND dependencies_of_io OpenEXR)
    endif()
  endif()
  set(swiftgs_${component}_dependencies ${dependencies_of_${component}})
endforeach()

configure_package_config_file(cmake/swiftgsConfig.cmake.in swiftgsConfig.cmake
  INSTALL_DESTINATION "${package_dir}" NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
# Until 1.0 a minor version may break callers.
write_basic_package_version_file(swiftgsConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/swiftgsConfig.cmake" "${PROJECT_BINARY_DIR}/swiftgsConfigVersion.cmake"
              cmake/FindWebP.cmake cmake/Findlibzip.cmake
        DESTINATION "${package_dir}" COMPONENT dev)
