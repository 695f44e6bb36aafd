#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Tests and measures frames over ranks on a machine with two GPUs or more.
#   benchmarks/mpi/measure_gpus.sh OUTDIR [STEP...]
# Steps, each with its own OUTDIR/STEP.log; without any, all of them in this order:
#   test      frames of ranks with a device each have the bits of one process
#   one       frames of one process without ranks, by swiftgs bench
#   strong    one scene on one rank and on two: garden at 3891x2520 and builtin:12000000 at 3840x2160
#   weak      builtin:6000000 a rank
#   large     100 million Gaussians on all ranks
#   views     24 views of garden on one rank and shared out among all
# Programs are those of SWIFTGS_BUILD, mpirun is LAUNCH, garden is GARDEN (its folder). RANKS names another number of
# ranks than two. CARRIERS are what brings splats from rank to rank, in turns: host,nccl,host,nccl in a build with NCCL.
# Images of all must be the same. OUTDIR/frames.jsonl has a line a run and carrier; model.py reads it.
set -euo pipefail
all_steps=(test one strong weak large views)
[ $# -ge 1 ] || { echo "usage: benchmarks/mpi/measure_gpus.sh OUTDIR [${all_steps[*]}]" >&2; exit 2; }
out=$1
shift
[ $# -gt 0 ] || set -- "${all_steps[@]}"
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=${SWIFTGS_BUILD:-$root/build/release}
launch=${LAUNCH:-mpirun --oversubscribe --bind-to none}
garden=${GARDEN:-$root/../shared/scenes/garden}
ranks=${RANKS:-2}
carriers=${CARRIERS:-host}
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
mkdir -p "$out"

frames() {  # frames RANKS SCENE [options]
  local n=$1
  shift
  [ "$n" = 1 ] || set -- "$@" --carriers "$carriers"
  echo "measure: $n ranks, $*" >&2
  $launch -n "$n" "$build/benchmarks/frames_over_ranks" "$@" --backend cuda | tee -a "$out/frames.jsonl"
}
garden_frames() { frames "$1" "$garden/garden.spz" --cameras "$garden/cameras.json" --view 0 --scale "$2"; }

step_test() {
  for n in 1 2 3; do $launch -n "$n" "$build/tests/mpi/mpi_cuda_frames_test"; done
}
step_one() {
  "$build/examples/swiftgs" bench "$garden" --views 0 --scales 3 --errors none \
    --renderers 'cuda/early/axis-shared-threshold-float-cholesky/ellipse' --json "$out/one-garden.json"
  "$build/examples/swiftgs" bench builtin:12000000 --views 0 --scales 3 --errors none \
    --renderers 'cuda/early/axis-shared-threshold-float-cholesky/ellipse' --json "$out/one-builtin.json"
}
step_strong() {
  for scale in 1 3; do for n in 1 "$ranks"; do garden_frames "$n" "$scale"; done; done
  for n in 1 "$ranks"; do frames "$n" builtin:12000000 --scale 3; done
}
step_weak() {
  for n in 1 "$ranks"; do frames "$n" "builtin:$((6000000 * n))" --scale 3; done
}
step_views() {
  for n in 1 "$ranks"; do
    for scale in 1 3; do
      $launch -n "$n" "$build/benchmarks/frames_over_ranks" "$garden/garden.spz" --cameras "$garden/cameras.json" \
        --views 24 --scale "$scale" --backend cuda | tee -a "$out/views.jsonl"
    done
  done
}
step_large() { frames "$ranks" builtin:100000000 --scale 3 --frames 10; }

for step in "$@"; do
  [[ " ${all_steps[*]} " == *" $step "* ]] || { echo "measure: '$step' is no step; expected ${all_steps[*]}" >&2; exit 2; }
  "step_$step" 2>&1 | tee "$out/$step.log"
done
