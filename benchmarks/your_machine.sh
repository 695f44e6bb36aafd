#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Your machine, your scene: time against error, and the paper's Tables 1 to 4.
#   benchmarks/your_machine.sh OUTDIR SCENE [OPTION...]
# SCENE is one of `swiftgs bench`, as builtin:20000 or the folder of a capture. OPTIONs go to `swiftgs bench`, as
# `--scales 0.25`, `--views 0,8` or `--max-frames 12`. Every backend that runs here is measured: cuda and cpu, or else
# serial. A second call with the same words goes on where the first was stopped. OUTDIR gets a folder of result files for
# each backend, README.md with the tables, and report.html with the figures. The program is that of SWIFTGS_BUILD, else of
# build/release.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
[ $# -ge 2 ] || { echo "usage: benchmarks/your_machine.sh OUTDIR SCENE [OPTION of swiftgs bench...]" >&2; exit 2; }
out=$1 scene=$2
shift 2
swiftgs=${SWIFTGS_BUILD:-$here/../build/release}/examples/swiftgs
[ -x "$swiftgs" ] || { echo "your_machine: expected a program at $swiftgs; build the target swiftgs_cli" >&2; exit 1; }
mkdir -p "$out"

backends=()
for backend in cuda cpu serial; do
  [ "$backend" = serial ] && [ ${#backends[@]} -gt 0 ] && continue
  ! "$swiftgs" list | grep "^$backend/.* runs here$" >/dev/null || backends+=("$backend")
done
[ ${#backends[@]} -gt 0 ] || { echo "your_machine: no renderer runs here; see swiftgs list" >&2; exit 1; }

half=axis-shared-threshold-half-split float=axis-shared-threshold-float-cholesky square=three-sigma-square

# part_of_capture MEMBER: `cameras` or `photos`, as `swiftgs info` finds them; nothing where they are not there.
part_of_capture() {
  "$swiftgs" info "$scene" --json - |
    python3 -c 'import json, sys; print(json.load(sys.stdin).get(sys.argv[1]) or "")' "$1"
}

# A tenth of the scene, for Table 4: a capture whose cameras and photographs are links; of the built-in scene a file.
prune() {
  local folder=$out/pruned cameras photos
  case $scene in builtin | builtin:*) pruned=$folder.ply ;; *) pruned=$folder ;; esac
  [ ! -e "$pruned" ] || return 0
  echo "your_machine: a tenth of $scene" >&2
  if [ "$pruned" = "$folder.ply" ]; then
    "$swiftgs" prune "$scene" --keep 0.1 --out "$pruned"
    return
  fi
  cameras=$(part_of_capture cameras) photos=$(part_of_capture photos)
  mkdir -p "$folder.unfinished"
  if [ -d "$cameras" ]; then ln -sfn "$(realpath "$cameras")" "$folder.unfinished/sparse"; else
    ln -sfn "$(realpath "$cameras")" "$folder.unfinished/cameras.json"
  fi
  [ -z "$photos" ] || ln -sfn "$(realpath "$photos")" "$folder.unfinished/photos"
  "$swiftgs" prune "$scene" --keep 0.1 --out "$folder.unfinished/pruned.ply"
  mv "$folder.unfinished" "$folder"
}

# bench BACKEND FILE SCENE ARGUMENT...: rows that the file has already stay.
bench() {
  local backend=$1 file=$2
  shift 2
  echo "your_machine: $backend/$file.json" >&2
  "$swiftgs" bench "$@" --json "$out/$backend/$file.json" --resume
}

options=("$@")
# A file has no cameras, and is drawn from one view that is found for it.
of_pruned=()
case $scene in
  builtin | builtin:*)
    while [ $# -gt 0 ]; do
      case $1 in --views) shift ;; --views=*) ;; *) of_pruned+=("$1") ;; esac
      shift
    done ;;
  *) of_pruned=("$@") ;;
esac
for backend in "${backends[@]}"; do
  mkdir -p "$out/$backend"
  steps=$backend/standard/*/opacity-box,$backend/early/*/opacity-box,$backend/early/*/ellipse
  steps+=,$backend/early/$float/obb,$backend/adaptive/per-pixel/opacity-box,$backend/adaptive/$half/opacity-box
  steps+=,$backend/adaptive/$float/opacity-box,$backend/adaptive/$float/ellipse,$backend/standard/$float/ellipse
  steps+=,$backend/standard/per-pixel/$square
  vanilla=$backend/standard/per-pixel/$square,$backend/adaptive/$half/$square,$backend/adaptive/$float/$square
  vanilla+=,$backend/adaptive/$float/ellipse
  bench "$backend" matrix "$scene" --renderers "$steps" --errors 3 ${options[@]+"${options[@]}"}
  bench "$backend" vanilla "$scene" --renderers "$vanilla" --conventions inria --errors 1 \
    ${options[@]+"${options[@]}"}
  prune
  bench "$backend" pruned "$pruned" --renderers "$vanilla" --conventions inria --errors 1 \
    ${of_pruned[@]+"${of_pruned[@]}"}
done

# table HEADING NAME...: a block of each backend.
table() {
  local backend
  printf '\n## %s\n' "$1"
  for backend in "${backends[@]}"; do printf '\n<!-- table: %s %s -->\n<!-- end -->\n' "$2" "$backend"; done
}
paper() { printf '\nThe paper:\n\n<!-- table: %s -->\n<!-- end -->\n' "$1"; }
{
  title=${scene%/}
  printf '# %s on this machine\n' "${title##*/}"
  table 'Time against error' pareto
  table 'Tables 1 and 2: time and speed-up' steps
  paper paper-scenes
  paper paper-steps
  table 'Table 3: what precision costs' accuracy
  paper paper-accuracy
  table 'Table 4: vanilla' vanilla
  table 'Table 4: a tenth of the Gaussians' pruned
  paper paper-pruned
} >"$out/README.md"
"$here/update_tables.py" --results "$out" "$out/README.md"
results=()
for backend in "${backends[@]}"; do results+=("$out/$backend/matrix.json"); done
"$swiftgs" report "${results[@]}" --out "$out/report.html"
echo "your_machine: $out/README.md has the tables, $out/report.html the figures"
