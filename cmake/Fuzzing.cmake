# SPDX-License-Identifier: Apache-2.0
if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  message(FATAL_ERROR "SWIFTGS_BUILD_FUZZERS: expected clang, which has libFuzzer; "
                      "found ${CMAKE_CXX_COMPILER_ID}. Try: cmake --preset fuzz")
endif()
add_compile_options(-fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined)
add_link_options(-fsanitize=address,undefined)
