#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Has ncu time the kernels of single frames on a GPU, and count how often each of their instructions is executed.
#   benchmarks/profile_kernels.sh OUTDIR [SCENE...]
# Scenes default to the captures in SWIFTGS_SCENES. `swiftgs bench --profile` draws the frames; the program is that of
# SWIFTGS_BUILD, else of build/gpu, where measure_cuda.sh builds. Leaves kernels-SCENE.csv of each scene,
# instructions-SCENE.csv of one, garden where it is among them, and profile.json, which names the machine; needs ncu and
# python3. Nothing else should run meanwhile.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
[ $# -ge 1 ] || { echo "usage: benchmarks/profile_kernels.sh OUTDIR [SCENE...]" >&2; exit 2; }
command -v ncu >/dev/null || { echo "profile: expected ncu in PATH" >&2; exit 1; }
mkdir -p "$1"
out=$(cd "$1" && pwd)
shift
build=${SWIFTGS_BUILD:-$here/../build/gpu}
program=$build/examples/swiftgs
[ -x "$program" ] || { echo "profile: expected a program at $program; measure_cuda.sh builds it" >&2; exit 1; }
export SWIFTGS_SCENES=${SWIFTGS_SCENES:-$here/../../shared/scenes}
if [ $# -eq 0 ]; then
  for folder in "$SWIFTGS_SCENES"/*/; do [ -d "$folder" ] && set -- "$@" "$(basename "$folder")"; done
  [ $# -gt 0 ] || set -- builtin
fi

"$here/describe_machine.sh" "$build" "benchmarks/profile_kernels.sh OUTDIR $*" >"$out/profile.json"

# draw SCENE RENDERERS NCU_OPTION...
draw() {
  local scene=$1 renderers=$2
  shift 2
  [[ "$scene" == builtin* ]] || scene=$SWIFTGS_SCENES/$scene
  ncu --profile-from-start off --clock-control none "$@" "$program" bench "$scene" --profile --views 0 \
    --renderers "$renderers"
}
# One frame of each rasterizer, and of each sort with the one that is best.
best=axis-shared-threshold-float-cholesky
metrics=gpu__time_duration.sum,smsp__inst_executed.sum,dram__bytes.sum,launch__registers_per_thread
metrics+=,sm__warps_active.avg.pct_of_peak_sustained_active,smsp__issue_active.avg.pct_of_peak_sustained_active
for scene in "$@"; do
  echo "profile: kernels, $scene"
  draw "$scene" "cuda/early/*/ellipse,cuda/standard/$best/ellipse" --print-units base --metrics $metrics --csv \
    2>/dev/null | grep '^"' >"$out/kernels-${scene/:/-}.csv" || echo "profile: ncu failed for $scene" >&2
done
scene=$1
for other in "$@"; do [ "$other" != garden ] || scene=garden; done
echo "profile: instructions, $scene"
report=$(mktemp -d)/report
draw "$scene" "cuda/early/*/ellipse" --section SourceCounters --kernel-name 'regex:raster_(per_pixel|half_split|warps)' \
  -o "$report" >/dev/null 2>&1 ||
  echo "profile: ncu failed for $scene" >&2
# Only what the tables need: the machine code, from address 0 on, and how often it was executed; of several launches of a
# kernel, the last.
ncu --import "$report.ncu-rep" --page source --csv | python3 -c '
import csv, re, sys
keep = ("Address", "Source", "Instructions Executed", "Predicated-On Thread Instructions Executed")
columns, kernels = [], {}
for row in csv.reader(sys.stdin):
    if row and row[0] == "Kernel Name":
        rows = kernels[row[1]] = [row[:2]]
    elif row and (row[0] == "Address" or row[0].startswith("0x")):
        columns = [row.index(name) for name in keep] if row[0] == "Address" else columns
        rows.append([row[c].strip() for c in columns])
        if row[0] != "Address":
            base = int(row[0], 16) if len(rows) == 3 else base
            rows[-1][:2] = [re.sub("0x[0-9a-f]{9,}", lambda at: hex(int(at[0], 16) - base), text) for text in rows[-1][:2]]
csv.writer(sys.stdout, lineterminator="\n").writerows(row for rows in kernels.values() for row in rows)' >"$out/instructions-${scene/:/-}.csv" ||
  { rm "$out/instructions-${scene/:/-}.csv"; echo "profile: no report of $scene" >&2; }
rm -f "$report.ncu-rep"
rmdir "$(dirname "$report")"
