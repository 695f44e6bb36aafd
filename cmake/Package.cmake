# SPDX-License-Identifier: Apache-2.0

# Debian packages of what is installed: `cpack` in a build by the preset `distribution`. Those of shared libraries are
# named for the interface, so that programs of two versions run side by side.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR SwiftGS)
set(CPACK_PACKAGE_CONTACT "SwiftGS contributors <swiftgs@users.noreply.github.com>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "renderer of 3D Gaussian splatting")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)  # half of what gzip makes of kernels
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
# Where our libraries find each other while what they need of the system is computed.
foreach(folder IN ITEMS . cpu cuda vulkan bindings/c bridges/gl bridges/cuda_vulkan parts/builtin parts/io
        parts/pages parts/reference)
  list(APPEND CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/backends/${folder}")
endforeach()
# Writes what each package says of its licences and changes.
set(CPACK_PRE_BUILD_SCRIPTS "${PROJECT_SOURCE_DIR}/cmake/PackageDocs.cmake")
set(CPACK_SWIFTGS_SOURCE "${PROJECT_SOURCE_DIR}")
set(CPACK_SWIFTGS_BUILD "${PROJECT_BINARY_DIR}")

# What the loader knows is brought up to date when a shared library comes or goes.
set(triggers "${PROJECT_BINARY_DIR}/triggers")
file(WRITE "${triggers}" "activate-noawait ldconfig\n")

# swiftgs_package(component name section description [dependency...])
#
# Beside the dependencies that dpkg-shlibdeps computes. `@` stands for exactly this version.
macro(swiftgs_package component name section description)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} upper)
  string(REPLACE ";" ", " depends "${ARGN}")
  string(REPLACE "@" " (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})" depends "${depends}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${depends}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${description}")
  if("${section}" STREQUAL "libs")
    set(CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA "${triggers}")
  endif()
endmacro()

set(CPACK_COMPONENTS_ALL)
set(interface ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(libraries)
if(TARGET swiftgs_cuda)
  set(name libswiftgs-cuda${interface})
  swiftgs_package(cuda ${name} libs "This package has the shared libraries that render on NVIDIA GPUs, also for OpenGL
and Vulkan. They need the driver; without one they load, and say that they are not usable.")
  list(APPEND libraries ${name}@)
endif()
set(name libswiftgs${interface})
set(draws_on "processors")
if(TARGET swiftgs_vulkan)
  set(draws_on "processors and on GPUs by Vulkan")
  set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS libvulkan1)
  set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS glslang-tools)  # shaders of policies of programs
endif()
swiftgs_package(runtime ${name} libs "This package has the shared libraries of C++: the renderer on
${draws_on}, the built-in scene, the float64
reference, readers and writers of scenes, and the table of renderers." ${libraries})
list(APPEND libraries ${name}@)
if(TARGET swiftgs_cli)
  swiftgs_package(tools swiftgs graphics "This package has the command-line tool, which renders,
converts, compares and measures scenes." ${libraries})
endif()
if(TARGET swiftgs_c)
  get_target_property(interface_of_c swiftgs_c SOVERSION)
  set(name libswiftgs-c${interface_of_c})
  swiftgs_package(c ${name} libs "This package has the shared library of the C interface, on which Python rests."
    ${libraries})
  list(APPEND libraries ${name}@)
  if(SWIFTGS_BUILD_PYTHON)
    swiftgs_package(python python3-swiftgs python "This package has the module for Python, which draws into arrays of
NumPy, PyTorch, CuPy and JAX." ${name}@ python3 python3-numpy)
    set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
    set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
    # Python's own files beside the sources come and go with them.
    file(WRITE "${PROJECT_BINARY_DIR}/postinst" "#!/bin/sh\nset -e\npy3compile -p python3-swiftgs\n")
    file(WRITE "${PROJECT_BINARY_DIR}/prerm" "#!/bin/sh\nset -e\npy3clean -p python3-swiftgs\n")
    set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${PROJECT_BINARY_DIR}/postinst;${PROJECT_BINARY_DIR}/prerm")
  endif()
endif()
swiftgs_package(dev libswiftgs-dev libdevel "This package has the headers, and the files for CMake and pkg-config."
  ${libraries} libglm-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
include(CPack)
