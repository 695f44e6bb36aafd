# SPDX-License-Identifier: Apache-2.0

# Draws a frame by PROGRAM at each width of lavapipe's vectors: all have the same bits.
foreach(width IN ITEMS 128 256 512)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env LP_NATIVE_VECTOR_WIDTH=${width}
    "${PROGRAM}" "--test-case=vulkan: a frame has bits*" OUTPUT_VARIABLE said RESULT_VARIABLE result)
  if(result EQUAL 77)
    message("skipped: ${said}")
    return()
  elseif(NOT said MATCHES "bits of a frame: ([0-9]+)")
    message(FATAL_ERROR "vectors of ${width} bits: expected the bits of a frame, found ${said}")
  elseif(DEFINED expected AND NOT CMAKE_MATCH_1 STREQUAL expected)
    message(FATAL_ERROR "vectors of ${width} bits: the frame is ${CMAKE_MATCH_1}, expected ${expected} as of 128")
  endif()
  set(expected "${CMAKE_MATCH_1}")
endforeach()
