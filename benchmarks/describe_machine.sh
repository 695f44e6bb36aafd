#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Prints as JSON what was measured and on what; of a GPU only where there is one.
#   benchmarks/describe_machine.sh BUILD COMMAND
# BUILD is the folder of the build. COMMIT names what was built where git cannot tell.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
[ $# -eq 2 ] || { echo "usage: benchmarks/describe_machine.sh BUILD COMMAND" >&2; exit 2; }
build=$1 command=$2

of_cache() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt" 2>/dev/null || true; }
ask_gpu() { nvidia-smi --query-gpu="$1" --format=csv,noheader | sed -n 1p; }
# What compiled the kernels: as CMake found it, for nvcc may be gone or outside of PATH.
cuda_version() {
  local found
  found=$(sed -n 's/^set(CMAKE_CUDA_COMPILER_VERSION "\(.*\)")$/\1/p' "$build"/CMakeFiles/*/CMakeCUDACompiler.cmake \
    2>/dev/null | sed -n 1p) || true
  [ -n "$found" ] || found=$(PATH=$PATH:/usr/local/cuda/bin nvcc --version 2>/dev/null | sed -n 's/.*release.* V//p') || true
  echo "${found:-unknown}"
}

cpu=$(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | sed -n 1p)
compiler=$(of_cache CMAKE_CXX_COMPILER)
kind=$(of_cache CMAKE_BUILD_TYPE | tr '[:lower:]' '[:upper:]')
flags="$(of_cache CMAKE_CXX_FLAGS) $(of_cache "CMAKE_CXX_FLAGS_$kind")"
gpu=
if nvidia-smi >/dev/null 2>&1; then
  gpu="\"gpu\": \"$(ask_gpu name)\", \"driver\": \"$(ask_gpu driver_version)\", \"cuda\": \"$(cuda_version)\",
 \"gpu_memory\": \"$(ask_gpu memory.total)\", \"gpu_clock\": \"$(ask_gpu clocks.max.sm)\",
 "
fi
cat <<END
{"date": "$(date -u +%F)", ${gpu}"cpu": "${cpu:-unknown}", "cores": $(nproc),
 "memory_gib": $(awk '/MemTotal/ { printf "%.0f", $2 / 1048576 }' /proc/meminfo),
 "system": "$(. /etc/os-release && echo "$PRETTY_NAME")",
 "compiler": "$("${compiler:-c++}" --version 2>/dev/null | sed -n 1p)", "flags": "$(xargs <<<"$flags")",
 "commit": "${COMMIT:-$(git -C "$here" rev-parse HEAD 2>/dev/null || echo unknown)}",
 "changed_files": $(git -C "$here" status --porcelain -uno -- ../include ../backends 2>/dev/null | wc -l),
 "load_before": $(cut -d ' ' -f 1 /proc/loadavg),
 "command": "$command"}
END
