# SPDX-License-Identifier: Apache-2.0

# Whether swiftgs::vulkan is built: it takes the headers of Vulkan, and compiles its shaders by glslangValidator.
# Off unless asked for.
set(SWIFTGS_BUILD_VULKAN OFF CACHE STRING "")
find_package(Vulkan QUIET COMPONENTS glslangValidator)
swiftgs_auto_option(SWIFTGS_BUILD_VULKAN "Build swiftgs::vulkan (needs the headers of Vulkan and glslangValidator)"
  Vulkan_INCLUDE_DIRS AND TARGET Vulkan::glslangValidator)
if(SWIFTGS_BUILD_VULKAN AND NOT (Vulkan_INCLUDE_DIRS AND TARGET Vulkan::glslangValidator))
  message(FATAL_ERROR "SWIFTGS_BUILD_VULKAN: expected the headers of Vulkan and glslangValidator (packages "
                      "libvulkan-dev and glslang-tools)")
endif()
