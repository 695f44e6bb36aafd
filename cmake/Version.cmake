# SPDX-License-Identifier: Apache-2.0

# Sets `result` to the version that include/swiftgs/version.hpp states.
function(swiftgs_read_version result)
  set(header "${CMAKE_CURRENT_SOURCE_DIR}/include/swiftgs/version.hpp")
  file(READ "${header}" text)
  foreach(part IN ITEMS MAJOR MINOR PATCH)
    if(NOT text MATCHES "#define SWIFTGS_VERSION_${part} ([0-9]+)\n")
      message(FATAL_ERROR "${header}: expected '#define SWIFTGS_VERSION_${part} NUMBER'")
    endif()
    list(APPEND parts ${CMAKE_MATCH_1})
  endforeach()
  list(JOIN parts . version)
  string(FIND "${text}" "string_view version = \"${version}\";" found)
  if(found EQUAL -1)
    message(FATAL_ERROR "${header}: expected the string to be \"${version}\", as the numbers say")
  endif()
  set(${result} ${version} PARENT_SCOPE)
endfunction()
