# SPDX-License-Identifier: Apache-2.0

# swiftgs_compile_shader(TARGET HEADER ARRAY SHADER [argument...]): compiles HEADER into TARGET, with the SPIR-V of SHADER.
function(swiftgs_compile_shader target header array shader)
  add_custom_command(OUTPUT "${header}" DEPENDS "${shader}" DEPFILE "${header}.d" VERBATIM
    COMMAND "${Vulkan_GLSLANG_VALIDATOR_EXECUTABLE}" --quiet -Os -V --target-env vulkan1.2 ${ARGN} --vn ${array}
            --depfile "${header}.d" -o "${header}" "${shader}")
  target_sources(${target} PRIVATE "${header}")
endfunction()
