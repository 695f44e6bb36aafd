#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Builds SwiftGS on a machine with a GPU and tests the CUDA renderers there. benchmarks/measure_matrix.sh measures them.
#   tests/cuda/on_gpu.sh OUTDIR [STEP...]
# Steps, each with its own OUTDIR/STEP.log; without any, all of them in this order:
#   build      configures and builds for the GPU that is there; in build/gpu, or where SWIFTGS_BUILD says
#   test       runs the tests labelled `gpu`
#   memcheck racecheck synccheck initcheck      run them again, those labelled `long` left out, under
#              this tool of compute-sanitizer; racecheck watches only kernels of SwiftGS
# Libraries from an unpacked archive instead of the system's: SWIFTGS_PREFIX=FOLDER, with SWIFTGS_SKIP_SETUP=1.
set -euo pipefail
all_steps=(build test memcheck racecheck synccheck initcheck)
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
[ $# -ge 1 ] || { echo "usage: tests/cuda/on_gpu.sh OUTDIR [${all_steps[*]}]" >&2; exit 2; }
out=$1
shift
[ $# -gt 0 ] || set -- "${all_steps[@]}"
for step in "$@"; do
  [[ " ${all_steps[*]} " == *" $step "* ]] ||
    { echo "on_gpu: '$step' is no step; expected ${all_steps[*]}" >&2; exit 2; }
done
mkdir -p "$out"
out=$(cd "$out" && pwd)
build=${SWIFTGS_BUILD:-$root/build/gpu}
export SWIFTGS_SCENES=${SWIFTGS_SCENES:-$root/../shared/scenes}
[ -z "${SWIFTGS_PREFIX:-}" ] ||
  export LD_LIBRARY_PATH=$SWIFTGS_PREFIX/usr/lib/x86_64-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}

usable() { "$build/examples/swiftgs" list | grep '^cuda/.* runs here$' >/dev/null; }

step_build() {
  "$root/cmake/setup.sh" test
  local options=()
  # The folder of headers is named because some packages take /usr for their own place.
  [ -z "${SWIFTGS_PREFIX:-}" ] ||
    options=("-DCMAKE_PREFIX_PATH=$SWIFTGS_PREFIX/usr" -DCMAKE_LIBRARY_ARCHITECTURE=x86_64-linux-gnu
             "-DCMAKE_CXX_FLAGS=-isystem $SWIFTGS_PREFIX/usr/include"
             "-DCMAKE_CUDA_FLAGS=-isystem $SWIFTGS_PREFIX/usr/include")
  cd "$root"
  cmake --preset release -B "$build" -DSWIFTGS_BUILD_CUDA=ON "-DSWIFTGS_SCENES=$SWIFTGS_SCENES" "${options[@]}"
  cmake --build "$build" --parallel "$(nproc)"
}

step_test() { ctest --test-dir "$build" -L gpu --no-tests=error --output-on-failure --output-junit "$out/gpu.xml"; }

# A process for each test would mostly start up: those of one program run together.
sanitize() {
  local tool=$1 failed=0 status command
  ctest --test-dir "$build" -L gpu -LE long --show-only=json-v1 | python3 -c '
import json, shlex, sys
programs = {}
for test in json.load(sys.stdin)["tests"]:
    program, *arguments = test["command"]
    cases = programs.setdefault(program, [])
    cases += [argument.removeprefix("--test-case=") for argument in arguments]
for program, cases in programs.items():
    print(shlex.join([program] + (["--test-case=" + ",".join(cases)] if cases else [])))' >"$out/programs.txt"
  while IFS= read -r command; do
    echo "$tool: ${command%% *}"
    status=0
    eval "compute-sanitizer --tool $* --error-exitcode 99 $command" </dev/null || status=$?
    # A program whose tests are all skipped returns 77.
    [ $status -eq 0 ] || [ $status -eq 77 ] || { echo "$tool: failed with $status: ${command%% *}"; failed=1; }
  done <"$out/programs.txt"
  rm "$out/programs.txt"
  return $failed
}
step_memcheck() { sanitize memcheck --leak-check full; }
# Of our kernels alone: those of CUB, which sorts and scans, are watched for long and warned of without a race of ours.
step_racecheck() { sanitize racecheck --kernel-regex kns=swiftgs; }
step_synccheck() { sanitize synccheck; }
step_initcheck() { sanitize initcheck; }

failed=0
for step in "$@"; do
  if [ "$step" != build ] && [ ! -x "$build/examples/swiftgs" ]; then
    echo "on_gpu: expected a build in $build; begin with the step 'build'" >&2
    exit 1
  fi
  # Without a GPU, its tests are skipped, and the steps after them cannot run.
  if [[ "$step" != @(build|test) ]] && ! usable; then break; fi
  started=$SECONDS
  set +e  # bash would ignore it in a command whose status is tested
  (set -e; "step_$step") >"$out/$step.log" 2>&1
  status=$?
  set -e
  if [ $status -eq 0 ]; then
    echo "on_gpu: $step done in $((SECONDS - started)) s, $out/$step.log"
  else
    failed=1
    tail -n 20 "$out/$step.log"
    echo "on_gpu: $step FAILED after $((SECONDS - started)) s, $out/$step.log"
    [ "$step" != build ] || exit 1
  fi
done
usable || { echo "on_gpu: no usable GPU here: the tests that need one were skipped" >&2; exit 1; }
exit $failed
