#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Installs what is missing, builds everything with warnings as errors, for CUDA where nvcc is there, and runs every
# test: units, header and compile-fail checks, installation, documentation, hard frames again for this processor under
# sanitizers, and the fuzz targets for a few seconds each. Tests that need a GPU are built where there is one.
# Says why tests were skipped and which failed, then ends with one line, 'N passed, N failed, N skipped', and fails when
# one test did.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

passed=0 failed=0 skipped=0 reasons= failed_names=

# Runs the workflow preset $1 and adds its results, which ctest leaves in JUnit form.
run_workflow() {
  local results=build/$1/junit.xml
  rm -f "$results"
  cmake --workflow --preset "$1"
  local status=$? tests=0 failures=0 not_run=0
  if [ -f "$results" ]; then
    attribute() { sed -n "1,/<testcase/s/.*\b$1=\"\([0-9]*\)\".*/\1/p" "$results" | sed -n 1p; }
    tests=$(attribute tests) failures=$(attribute failures)
    not_run=$(($(attribute skipped) + $(attribute disabled)))
    reasons+=$(sed -n '/<skipped /,/<[/]testcase>/s/^\(.*MESSAGE: \|.*<system-out>\)\{0,1\}skipped: \([^<]*\).*/\2/p' "$results")$'\n'
    failed_names+=$(sed -n "s/.*<testcase name=\"\([^\"]*\)\".* status=\"fail\".*/test: failed in $1: \1/p" "$results")$'\n'
  fi
  # A workflow that ends before its tests, or says that it failed when no test did, is a failure of its own.
  if [ "$status" -ne 0 ] && [ "$failures" -eq 0 ]; then
    tests=$((tests + 1)) failures=1
    failed_names+="test: failed in $1: its build, or no test ran"$'\n'
  fi
  passed=$((passed + tests - failures - not_run)) failed=$((failed + failures)) skipped=$((skipped + not_run))
}

skip() {  # skip REASON
  reasons+=$1$'\n'
  skipped=$((skipped + 1))
}

if cmake/setup.sh test; then
  export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
  export CTEST_PARALLEL_LEVEL=${CTEST_PARALLEL_LEVEL:-$(nproc)}
  command -v ccache >/dev/null && export CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_CUDA_COMPILER_LAUNCHER=ccache
  # Where nothing can run kernels, a fifth of the time compiles them. For a GPU that comes later, build anew.
  nvidia-smi -L >/dev/null 2>&1 || export CUDAFLAGS="${CUDAFLAGS:+$CUDAFLAGS }--Ofast-compile=max"
  run_workflow release
  if grep -q '^SWIFTGS_BUILD_CUDA:BOOL=OFF$' build/release/CMakeCache.txt 2>/dev/null; then
    skip 'no nvcc 13 or newer here: the CUDA backend'
  fi
  if [ "$(uname -m)" = x86_64 ] && ! grep -qw avx2 /proc/cpuinfo; then
    skip 'no AVX2 here: hard frames under sanitizers'
  else
    run_workflow asan-stability
  fi
  if command -v clang++ >/dev/null; then
    run_workflow fuzz
  else
    skip 'no clang++ here (package clang): the fuzz targets'
  fi
  skip 'left to cmake/release_check.sh: packages and wheel in fresh systems, CUDA in them, equal bytes, arm64, other compilers'
else
  failed=1
fi

sort <<<"$reasons" | uniq -c | sed -n 's/^ *\([0-9][0-9]*\) \(..*\)/test: \1 skipped, \2/p'
sed '/^$/d' <<<"$failed_names"
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
