# SPDX-License-Identifier: Apache-2.0

# swiftgs::core: headers only. What lies in io/ belongs to swiftgs::io, what lies in pages/ to swiftgs::pages, the
# built-in scene to swiftgs::builtin, the float64 reference and what is judged by it to swiftgs::reference.
find_package(glm REQUIRED CONFIG)

# Headers are found, not listed: one that is forgotten in a list would be neither checked nor installed.
file(GLOB_RECURSE swiftgs_core_headers CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/include/swiftgs/*.hpp")
set(swiftgs_io_headers "${swiftgs_core_headers}")
set(swiftgs_pages_headers "${swiftgs_core_headers}")
set(swiftgs_reference_headers "${swiftgs_core_headers}")
list(FILTER swiftgs_core_headers EXCLUDE REGEX
  "/include/swiftgs/(io/|pages/|builtin_scene[.]|reference[.]|stress[.])")
list(FILTER swiftgs_io_headers INCLUDE REGEX "/include/swiftgs/io/")
list(FILTER swiftgs_pages_headers INCLUDE REGEX "/include/swiftgs/pages/")
list(FILTER swiftgs_reference_headers INCLUDE REGEX "/include/swiftgs/(reference[.]|stress[.])")

add_library(swiftgs_core INTERFACE)
add_library(swiftgs::core ALIAS swiftgs_core)
set_target_properties(swiftgs_core PROPERTIES EXPORT_NAME core)
target_sources(swiftgs_core INTERFACE FILE_SET HEADERS
  BASE_DIRS "${PROJECT_SOURCE_DIR}/include" FILES ${swiftgs_core_headers}
  "${PROJECT_SOURCE_DIR}/include/swiftgs/lens/formulas.inc")
target_compile_features(swiftgs_core INTERFACE cxx_std_20)
target_link_libraries(swiftgs_core INTERFACE glm::glm)
