# SPDX-License-Identifier: Apache-2.0

# swiftgs_embed(TARGET HEADER NAMESPACE FILE...)
#
# Compiles files into TARGET. HEADER declares, in NAMESPACE, `std::string_view embedded(std::string_view name)`: the
# content of the file of that name, without its folder. The source that defines it is written when one of the files
# has changed, by this file in script mode.
function(swiftgs_embed target header namespace)
  set(source "${CMAKE_CURRENT_BINARY_DIR}/${target}_embedded.cpp")
  add_custom_command(OUTPUT "${source}"
    COMMAND ${CMAKE_COMMAND} "-DOUT=${source}" "-DHEADER=${header}" "-DNAMESPACE=${namespace}" "-DFILES=${ARGN}"
      -P "${CMAKE_CURRENT_FUNCTION_LIST_FILE}"
    DEPENDS ${ARGN} "${CMAKE_CURRENT_FUNCTION_LIST_FILE}" COMMENT "Embedding the files of ${target}" VERBATIM)
  target_sources(${target} PRIVATE "${source}")
endfunction()

if(NOT CMAKE_SCRIPT_MODE_FILE)
  return()
endif()
set(arrays "")
set(choices "")
set(number 0)
foreach(file IN LISTS FILES)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" bytes HEX)
  if(bytes STREQUAL "")
    message(FATAL_ERROR "${file}: expected a file that is not empty")
  endif()
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  string(APPEND arrays "constexpr unsigned char file_${number}[] = {${bytes}};\n")
  string(APPEND choices "  if (name == \"${name}\") return text(file_${number}, sizeof file_${number});\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE "${OUT}" "// SPDX-License-Identifier: Apache-2.0
#include \"${HEADER}\"

namespace ${NAMESPACE} {
namespace {
${arrays}
std::string_view text(const unsigned char* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}
}  // namespace

std::string_view embedded(std::string_view name) {
${choices}  return {};
}

}  // namespace ${NAMESPACE}
")
