# SPDX-License-Identifier: Apache-2.0

# swiftgs_native_gpus(RESULT): the compute capabilities of this machine's GPUs that nvcc 13 compiles for, as
# CMAKE_CUDA_ARCHITECTURES has them; empty where there are none. CMake's own `native` fails without a GPU.
function(swiftgs_native_gpus result)
  execute_process(COMMAND nvidia-smi --query-gpu=compute_cap --format=csv,noheader
    OUTPUT_VARIABLE found RESULT_VARIABLE status ERROR_QUIET)
  set(kinds)
  if(status EQUAL 0)
    string(REGEX MATCHALL "[0-9]+[.][0-9]" kinds "${found}")
    string(REPLACE "." "" kinds "${kinds}")
    list(REMOVE_DUPLICATES kinds)
    list(FILTER kinds EXCLUDE REGEX "^([0-6].|7[0-4])$")
  endif()
  set(${result} "${kinds}" PARENT_SCOPE)
endfunction()
