#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Measures the CPU renderers on this machine: times, errors against float64, growth with the scene.
#   benchmarks/measure_cpu.sh [OUTDIR [SCENE...]]
# OUTDIR defaults to benchmarks/results/DATE-CPU, scenes to the built-in one and the captures in SWIFTGS_SCENES.
# Leaves the raw results there as JSON and the tables as README.md; needs python3. Nothing else should run
# meanwhile. For a trial: REPETITIONS=1 MIN_TIME=0.01 SIZES=1000 benchmarks/measure_cpu.sh /tmp/trial builtin:1000
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cpu=$(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo | head -n 1)
out=${1:-$here/results/$(date -u +%F)-$(tr -cs '[:alnum:]' - <<<"${cpu:-unknown}" | tr '[:upper:]' '[:lower:]' | sed 's/-*$//')}
shift || true
export SWIFTGS_SCENES=${SWIFTGS_SCENES:-$here/../../shared/scenes}
repetitions=${REPETITIONS:-3} min_time=${MIN_TIME:-0.5} sizes=${SIZES:-13000000 3000000 1000000 300000 100000}
best='axis-shared-threshold-float-cholesky'

if [ $# -eq 0 ]; then
  set -- builtin
  for folder in "$SWIFTGS_SCENES"/*/; do [ -d "${folder}photos" ] && set -- "$@" "$(basename "$folder")"; done
fi
build=${SWIFTGS_BUILD:-$here/../build/release}
if [ -z "${SWIFTGS_BUILD:-}" ]; then
  (cd "$here/.." && cmake --preset release && cmake --build --preset release --target frames swiftgs_cli)
fi
mkdir -p "$out"

"$here/describe_machine.sh" "$build" \
  "REPETITIONS=$repetitions MIN_TIME=$min_time benchmarks/measure_cpu.sh OUTDIR $*" >"$out/machine.json"

# benchmark FILE FILTER SCENE...
benchmark() {
  local file=$1 filter=$2
  shift 2
  echo "measure: $file"
  "$build/benchmarks/frames" "$@" "--benchmark_filter=$filter" "--benchmark_min_time=$min_time" \
    "--benchmark_repetitions=$repetitions" "--benchmark_out=$out/$file" --benchmark_out_format=json >/dev/null
  # Whose machine it was and where it was built is nobody's business.
  sed -i '/"host_name":/d; /"executable":/d' "$out/$file"
}

# The largest first: what does not fit in memory should fail at once. A process each, for its peak memory.
for size in $sizes; do benchmark "scaling-$size.json" "^frame/cpu/early/$best/ellipse/" "builtin:$size"; done
benchmark frames.json "^frame/(cpu/.*|serial/(standard|early)/.*/ellipse)/" "$@"
captures=()
for scene in "$@"; do [ -d "$SWIFTGS_SCENES/$scene" ] && captures+=("$scene"); done
if [ ${#captures[@]} -gt 0 ]; then
  rasters="(per-pixel|axis-shared-float-cholesky|$best)"
  benchmark views.json "^views/cpu/(.*/$rasters/ellipse|early/$best/.*)/" "${captures[@]}"
fi

# Errors of every renderer on three views, and of the 3-sigma square where it defines the image.
for scene in "$@"; do
  input=("$scene" --views 0,8,16)
  if [ -d "$SWIFTGS_SCENES/$scene" ]; then
    cameras=$SWIFTGS_SCENES/$scene/cameras.json
    [ -e "$cameras" ] || cameras=$SWIFTGS_SCENES/$scene/sparse/0
    input=("$(ls "$SWIFTGS_SCENES/$scene/$scene".* | head -n 1)" --views 0,8,16 --cameras "$cameras"
           --photos "$SWIFTGS_SCENES/$scene/photos")
  fi
  echo "measure: check of $scene"
  "$build/examples/swiftgs" check "${input[@]}" --renderers 'cpu/*' --repeats 1 \
    --json "$out/check-gsplat-${scene/:/-}.json" >/dev/null
  "$build/examples/swiftgs" check "${input[@]}" --renderers 'cpu/early/*/three-sigma-square' --repeats 1 \
    --conventions inria --json "$out/check-inria-${scene/:/-}.json" >/dev/null
done

python3 "$here/tables.py" "$out" >"$out/README.md"
echo "measure: the tables are in $out/README.md"
