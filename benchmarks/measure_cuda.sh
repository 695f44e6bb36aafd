#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Builds SwiftGS on a machine with a GPU, tests the CUDA renderers there and measures them.
#   benchmarks/measure_cuda.sh OUTDIR [STEP...]
# Steps, each with its own OUTDIR/STEP.log; without any, all of them in this order:
#   build      configures and builds for the GPU that is there; in build/gpu, or where SWIFTGS_BUILD says
#   test       runs the tests labelled `gpu`
#   memcheck racecheck synccheck initcheck      run them again, those labelled `long` left out, under
#              this tool of compute-sanitizer; racecheck watches only kernels of SwiftGS
#   check      errors of every CUDA renderer against float64, on three views of each scene
#   bench      times of frames, of views and of stages
#   profile    profile_kernels.sh: times of kernels, and their instructions
# Scenes are the built-in one and the captures in SWIFTGS_SCENES; SCENES='fox garden' names others. REPETITIONS and
# MIN_TIME are those of Google Benchmark, BENCH_FILTER chooses among the renderers.
# Libraries from an unpacked archive instead of the system's: SWIFTGS_PREFIX=FOLDER, with SWIFTGS_SKIP_SETUP=1.
set -euo pipefail
all_steps=(build test memcheck racecheck synccheck initcheck check bench profile)
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
[ $# -ge 1 ] || { echo "usage: benchmarks/measure_cuda.sh OUTDIR [${all_steps[*]}]" >&2; exit 2; }
out=$1
shift
[ $# -gt 0 ] || set -- "${all_steps[@]}"
for step in "$@"; do
  [[ " ${all_steps[*]} " == *" $step "* ]] ||
    { echo "measure: '$step' is no step; expected ${all_steps[*]}" >&2; exit 2; }
done
mkdir -p "$out"
out=$(cd "$out" && pwd)
build=${SWIFTGS_BUILD:-$root/build/gpu}
export SWIFTGS_SCENES=${SWIFTGS_SCENES:-$root/../shared/scenes}
[ -z "${SWIFTGS_PREFIX:-}" ] ||
  export LD_LIBRARY_PATH=$SWIFTGS_PREFIX/usr/lib/x86_64-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
if [ -z "${SCENES:-}" ]; then
  SCENES=builtin
  for folder in "$SWIFTGS_SCENES"/*/; do [ -d "$folder" ] && SCENES+=" $(basename "$folder")"; done
fi

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

step_check() {
  local scene input conventions
  for scene in $SCENES; do
    input=$scene
    [ ! -d "$SWIFTGS_SCENES/$scene" ] || input=$SWIFTGS_SCENES/$scene
    for conventions in gsplat inria; do
      echo "check: $scene, $conventions"
      "$build/examples/swiftgs" check "$input" --views 0,8,16 --renderers 'cuda/*' --repeats 1 \
        --conventions $conventions --json "$out/check-$conventions-${scene/:/-}.json"
    done
  done
}

# benchmark FILE PROGRAM WHAT
benchmark() {
  # shellcheck disable=SC2086  # SCENES is a list
  "$build/benchmarks/$2" $SCENES "--benchmark_filter=^$3/cuda/(${BENCH_FILTER:-.*})" \
    "--benchmark_min_time=${MIN_TIME:-0.1}" "--benchmark_repetitions=${REPETITIONS:-3}" \
    "--benchmark_out=$out/$1" --benchmark_out_format=json
  # Whose machine it was and where it was built is nobody's business.
  sed -i '/"host_name":/d; /"executable":/d' "$out/$1"
}

step_bench() {
  "$root/benchmarks/describe_machine.sh" "$build" \
    "REPETITIONS=${REPETITIONS:-3} MIN_TIME=${MIN_TIME:-0.1} benchmarks/measure_cuda.sh OUTDIR bench" \
    >"$out/machine.json"
  benchmark frames.json frames '(frame|views)'
  benchmark stages.json stages '(project|sort|raster)'
}

step_profile() {
  # shellcheck disable=SC2086  # SCENES is a list
  SWIFTGS_BUILD=$build "$root/benchmarks/profile_kernels.sh" "$out" $SCENES
}

failed=0
for step in "$@"; do
  if [ "$step" != build ] && [ ! -x "$build/examples/swiftgs" ]; then
    echo "measure: expected a build in $build; begin with the step 'build'" >&2
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
    echo "measure: $step done in $((SECONDS - started)) s, $out/$step.log"
  else
    failed=1
    tail -n 20 "$out/$step.log"
    echo "measure: $step FAILED after $((SECONDS - started)) s, $out/$step.log"
    [ "$step" != build ] || exit 1
  fi
done
usable || { echo "measure: no usable GPU here: the tests that need one were skipped, nothing was measured" >&2; exit 1; }
exit $failed
