# SPDX-License-Identifier: Apache-2.0
#
# Fails if LIBRARY has another number of kernels for compute capability 9.0 than KERNELS, or if a kernel of sorts, of a
# thread a pixel, of half terms or of `for_each` spills registers. Kernels of float terms and of projection spill a few
# bytes for the sake of more warps, and those of several scenes keep them in local memory. CUB's own do not count.
#   cmake -DCUOBJDUMP=... -DLIBRARY=... -DKERNELS=... -P check_kernels.cmake
execute_process(COMMAND "${CUOBJDUMP}" --gpu-architecture sm_90 --dump-resource-usage "${LIBRARY}"
  OUTPUT_VARIABLE said COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "Function [^\n]*\n[^\n]*STACK:[0-9]+" kernels "${said}")
list(FILTER kernels EXCLUDE REGEX "^Function _ZN3cub")
list(LENGTH kernels number)
if(NOT number EQUAL KERNELS)
  message(SEND_ERROR "${LIBRARY}: ${number} kernels for sm_90; expected ${KERNELS}")
endif()
list(FILTER kernels INCLUDE REGEX "radix_|raster_per_pixelILb0|raster_half_splitILb.ELb0|for_each|pick_pixels")
if(NOT kernels)
  message(SEND_ERROR "${LIBRARY}: no kernel has one of these names; expected some")
endif()
list(FILTER kernels EXCLUDE REGEX "STACK:0$")
foreach(kernel IN LISTS kernels)
  message(SEND_ERROR "${kernel}: expected 0 bytes, as nothing is spilled")
endforeach()
