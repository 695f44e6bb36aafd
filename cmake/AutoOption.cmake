# SPDX-License-Identifier: Apache-2.0

# swiftgs_auto_option(NAME text condition...): ON, OFF, or AUTO, the default: ON where the condition holds. The cache
# keeps AUTO, so that configuring again finds what was installed since.
macro(swiftgs_auto_option name text)
  set(${name} AUTO CACHE STRING "${text}: ON, OFF, or AUTO: if found")
  set_property(CACHE ${name} PROPERTY STRINGS AUTO ON OFF)
  if(${name} STREQUAL "AUTO")
    set(${name} OFF)
    if(${ARGN})
      set(${name} ON)
    endif()
  endif()
endmacro()
