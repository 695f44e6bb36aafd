# SPDX-License-Identifier: Apache-2.0

# imgui::imgui, with its parts for GLFW and OpenGL 2. Debian's package of Dear ImGui has no files for CMake.
include(FindPackageHandleStandardArgs)
find_path(imgui_INCLUDE_DIR backends/imgui_impl_opengl2.h PATH_SUFFIXES imgui)
find_library(imgui_LIBRARY imgui)
find_library(imgui_STB_LIBRARY stb)  # Debian took it out of Dear ImGui
mark_as_advanced(imgui_INCLUDE_DIR imgui_LIBRARY imgui_STB_LIBRARY)
find_package_handle_standard_args(imgui DEFAULT_MSG imgui_LIBRARY imgui_INCLUDE_DIR)
if(imgui_FOUND AND NOT TARGET imgui::imgui)
  add_library(imgui::imgui UNKNOWN IMPORTED)
  set_target_properties(imgui::imgui PROPERTIES
    IMPORTED_LOCATION "${imgui_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${imgui_INCLUDE_DIR}")
  if(imgui_STB_LIBRARY)
    set_property(TARGET imgui::imgui PROPERTY INTERFACE_LINK_LIBRARIES "${imgui_STB_LIBRARY}")
  endif()
endif()
