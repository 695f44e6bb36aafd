#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Tests and measures frames over ranks on a machine with several GPUs.
#   benchmarks/mpi/measure_gpus.sh OUTDIR [STEP...]
# Steps, each with its own OUTDIR/STEP.log; without any, all of them in this order:
#   test      frames have the bits of one process, on 1 rank to one more than there are GPUs
#   strong    one scene on each number of ranks: garden at 1297x840 and 3891x2520, builtin:12000000 at 3840x2160
#   views     24 views of garden, shared out among each number of ranks
#   weak      builtin:6000000 a rank, on each number of ranks
#   large     50 million Gaussians a rank, on most ranks
# RANKS are the numbers of ranks, ascending: "1 2 4" for four GPUs; "1 2" without. Programs are those of SWIFTGS_BUILD,
# mpirun is LAUNCH, garden is GARDEN (its folder). CARRIERS are what brings splats from rank to rank, in turns:
# host,nccl,host,nccl in a build with NCCL. Images of all must be the same. OUTDIR/ranks.json has a row a run and carrier
# of frames, and a row a run of views.
set -euo pipefail
all_steps=(test strong views weak large)
[ $# -ge 1 ] || { echo "usage: benchmarks/mpi/measure_gpus.sh OUTDIR [${all_steps[*]}]" >&2; exit 2; }
out=$1
shift
[ $# -gt 0 ] || set -- "${all_steps[@]}"
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=${SWIFTGS_BUILD:-$root/build/release}
launch=${LAUNCH:-mpirun --oversubscribe --bind-to none}
garden=${GARDEN:-$root/../shared/scenes/garden}
read -ra ranks <<<"${RANKS:-1 2}"
most=${ranks[-1]}
carriers=${CARRIERS:-host}
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
mkdir -p "$out"

frames() {  # frames RANKS SCENE [options]
  local n=$1
  shift
  echo "measure: $n ranks, $*" >&2
  $launch -n "$n" "$build/benchmarks/frames_over_ranks" "$@" --backend cuda | tee -a "$out/rows"
}
frame() {  # frame RANKS SCENE [options]
  if [ "$1" = 1 ]; then frames "$@"; else frames "$@" --carriers "$carriers"; fi
}

step_test() {
  for ((n = 1; n <= most + 1; ++n)); do $launch -n "$n" "$build/tests/mpi/mpi_cuda_frames_test"; done
}
step_strong() {
  for scale in 1 3; do
    for n in "${ranks[@]}"; do frame "$n" "$garden/garden.spz" --cameras "$garden/cameras.json" --scale "$scale"; done
  done
  for n in "${ranks[@]}"; do frame "$n" builtin:12000000 --scale 3; done
}
step_views() {
  for scale in 1 3; do
    for n in "${ranks[@]}"; do
      frames "$n" "$garden/garden.spz" --cameras "$garden/cameras.json" --views 24 --scale "$scale"
    done
  done
}
step_weak() {
  for n in "${ranks[@]}"; do frame "$n" "builtin:$((6000000 * n))" --scale 3; done
}
step_large() { frame "$most" "builtin:$((50000000 * most))" --scale 3 --frames 10; }

for step in "$@"; do
  [[ " ${all_steps[*]} " == *" $step "* ]] || { echo "measure: '$step' is no step; expected ${all_steps[*]}" >&2; exit 2; }
  "step_$step" 2>&1 | tee "$out/$step.log"
done
[ ! -e "$out/rows" ] || "$root/benchmarks/result_file.sh" "$build" cat "$out/rows" >"$out/ranks.json"
