# SPDX-License-Identifier: Apache-2.0

# swiftgs_add_box_shaders(TARGET): headers with the compiled shaders of 19_vulkan, for example and test. Vulkan was found
# with glslangValidator.
function(swiftgs_add_box_shaders target)
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/shaders_of_${target}")
  foreach(stage IN ITEMS vert frag)
    set(shader "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/19_vulkan.${stage}")
    set(words "${folder}/19_vulkan.${stage}.hpp")
    add_custom_command(OUTPUT "${words}" DEPENDS "${shader}" VERBATIM
      COMMAND Vulkan::glslangValidator --quiet -V --vn box_${stage} -o "${words}" "${shader}")
    target_sources(${target} PRIVATE "${words}")
  endforeach()
  file(MAKE_DIRECTORY "${folder}")
  target_include_directories(${target} PRIVATE "${folder}")
endfunction()
