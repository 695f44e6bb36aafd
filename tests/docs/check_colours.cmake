# SPDX-License-Identifier: Apache-2.0

# cmake -DROOT=<sources> -P check_colours.cmake
#
# Fails where a public header calls colours linear, or where the one that explains them does not.
file(GLOB_RECURSE headers "${ROOT}/include/swiftgs/*.hpp" "${ROOT}/backends/*/include/*.hpp")
list(FILTER headers EXCLUDE REGEX "/include/swiftgs/builtin[./]")
set(found)
foreach(header IN LISTS headers)
  file(STRINGS "${header}" lines REGEX "linear(,| RGB)")
  foreach(line IN LISTS lines)
    string(APPEND found "\n${header}: ${line}")
  endforeach()
endforeach()
file(READ "${ROOT}/include/swiftgs/frame.hpp" frame)
if(NOT headers OR found OR NOT frame MATCHES "scene's own values" OR NOT frame MATCHES "sRGB framebuffer")
  message(FATAL_ERROR "expected colours in the scene's own values, explained in swiftgs/frame.hpp:${found}")
endif()
