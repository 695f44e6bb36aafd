# SPDX-License-Identifier: Apache-2.0

# cmake -DROOT=<sources> -P check_colours.cmake
#
# Fails where a public header or a page calls colours linear or display values, or where the header that explains them
# does not.
file(GLOB pages "${ROOT}/*.md" "${ROOT}/docs/*.md" "${ROOT}/backends/*.md" "${ROOT}/benchmarks/*.md")
file(GLOB_RECURSE headers "${ROOT}/include/swiftgs/*.hpp" "${ROOT}/backends/*/include/*.hpp")
set(found)
foreach(file IN LISTS headers pages)
  file(STRINGS "${file}" lines REGEX "(^|[^_.])linear(, [a-z]| RGB)|display values")
  foreach(line IN LISTS lines)
    string(APPEND found "\n${file}: ${line}")
  endforeach()
endforeach()
file(READ "${ROOT}/include/swiftgs/frame.hpp" frame)
if(NOT headers OR NOT pages OR found OR NOT frame MATCHES "scene's own values" OR NOT frame MATCHES "sRGB framebuffer")
  message(FATAL_ERROR "expected colours in the scene's own values, explained in swiftgs/frame.hpp:${found}")
endif()
