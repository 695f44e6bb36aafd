#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Measures, with `swiftgs`, what the pages of docs/ and the README print as tables.
#   benchmarks/measure_matrix.sh [--resume] OUTDIR [PART...]
# Parts, each with files of its own in OUTDIR; without any, all of them in this order:
#   matrix     matrix.json: every rasterizer with both sorts and three bounds, and what tables show of `adaptive` and
#              `obb`, over views of each scene, with errors and photographs
#   vanilla    vanilla.json: the 3-sigma square with the inria conventions, the paper's steps on it, and ours
#   gaussians  scaling-gaussians.json, scaling-builtin.json: 0.1 to 12 million of a capture's, and of the built-in scene
#   pixels     scaling-pixels.json: 0.25 to 33 million
#   threads    scaling-threads.json: of the cpu backend, whatever BACKEND is, up to as many as there are
#   occupancy  scaling-occupancy.json: scales of all Gaussians from an eighth to eight times theirs (four on a CPU);
#              tiles get no sparser than by one for each splat in view
#   prune      pruned.json: a tenth of each capture
#   lenses     lenses.json: four views of a capture with a cameras.json as pinholes, through OpenCV's lens, as fisheyes
#              and as panoramas, its Gaussians as they are and ordered in space
#   harmonics  harmonics-float.json, -smallest.json, -half.json: captures, and the built-in scene through SPZ and SOG, with
#              harmonics kept so
#   stress     stress.json: every rasterizer on every family of hard frames at every severity, 64x48, 16 seeds;
#              stress-large.json: three families at 960x540 and 1920x1080, 2 seeds
# BACKEND is cuda or cpu; by default cuda where it runs. Scenes are the built-in one and the captures in
# SWIFTGS_SCENES; SCENES='fox garden' names other captures. The program is that of SWIFTGS_BUILD, else of build/release.
#
# All parts but stress take about eight minutes of an H100 with 16 cores and half an hour of two cores; stress takes about
# six minutes of two cores, most of it for the float64 reference. What keeps them within that:
# frames end when the median is known to PRECISION, MIN_FRAMES, six or more, and MAX_FRAMES of them; a CPU takes every
# 24th view where a GPU takes every eighth (VIEWS), both of them of those that training has not seen; the float64
# reference, which takes longer than all frames together, is rendered for the first three views of a scene.
# Nothing else should run meanwhile. A part that fails says so, and the others run. OUTDIR/whole has the files as
# `swiftgs bench` writes them, row by row; with --resume their rows are not measured again, where machine, build, scenes
# and command are the same. What prune, convert and stress do begins anew.
set -euo pipefail
all_parts=(matrix vanilla gaussians pixels threads occupancy prune lenses harmonics stress)
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
resume=
[ "${1:-}" != --resume ] || { resume=--resume && shift; }
[ $# -ge 1 ] || { echo "usage: benchmarks/measure_matrix.sh [--resume] OUTDIR [${all_parts[*]}]" >&2; exit 2; }
out=$1
shift
[ $# -gt 0 ] || set -- "${all_parts[@]}"
for part in "$@"; do
  [[ " ${all_parts[*]} " == *" $part "* ]] ||
    { echo "measure: '$part' is no part; expected ${all_parts[*]}" >&2; exit 2; }
done
swiftgs=${SWIFTGS_BUILD:-$here/../build/release}/examples/swiftgs
[ -x "$swiftgs" ] || { echo "measure: expected a program at $swiftgs; build the target swiftgs_cli" >&2; exit 1; }
swiftgs=$(realpath "$swiftgs")
mkdir -p "$out/whole"
out=$(cd "$out" && pwd)
scenes=$(realpath "${SWIFTGS_SCENES:-$here/../../shared/scenes}")

runs_here() { "$swiftgs" list | grep "^$1/.* runs here$" >/dev/null; }
backend=${BACKEND:-$(runs_here cuda && echo cuda || echo cpu)}
runs_here "$backend" || { echo "measure: no renderer of the backend '$backend' runs here" >&2; exit 1; }

# Of fewer frames the median has no 95 % interval, and benchmarks/compare leaves their times out.
[[ "${MIN_FRAMES:-6}" =~ ^[0-9]{1,6}$ ]] && [ "$((10#${MIN_FRAMES:-6}))" -ge 6 ] ||
  { echo "measure: MIN_FRAMES is '$MIN_FRAMES'; expected 6 or more" >&2; exit 2; }
if [ "$backend" = cuda ]; then
  views=${VIEWS:-every:8} least=${MIN_FRAMES:-15} most=${MAX_FRAMES:-60} precision=${PRECISION:-0.01}
  sizes_of_builtin=(builtin builtin:1000000 builtin:4000000) enlarge=0.125,0.25,0.5,1,2,4,8
else
  views=${VIEWS:-every:24} least=${MIN_FRAMES:-6} most=${MAX_FRAMES:-12} precision=${PRECISION:-0.02}
  sizes_of_builtin=(builtin builtin:1000000) enlarge=0.125,0.25,0.5,1,2,4
fi

# part_of_capture FOLDER MEMBER: what `swiftgs info` finds in the folder of a capture, as `cameras` or `photos`; nothing
# where that is not there, or the folder is no capture.
part_of_capture() {
  { "$swiftgs" info "$1" --json - 2>/dev/null || echo '{}'; } |
    python3 -c 'import json, sys; print(json.load(sys.stdin).get(sys.argv[1]) or "")' "$2"
}

captures=()
if [ -n "${SCENES:-}" ]; then
  for name in $SCENES; do captures+=("$scenes/$name"); done
else
  for folder in "$scenes"/*/; do
    [ -z "$(part_of_capture "${folder%/}" cameras)" ] || captures+=("${folder%/}")
  done
fi
# Growth is shown on one capture: garden where it is there.
grown=(${captures[@]+"${captures[0]}"})
for capture in ${captures[@]+"${captures[@]}"}; do [[ "$capture" != */garden ]] || grown=("$capture"); done

ours=axis-shared-threshold-float-cholesky/ellipse
paper=axis-shared-threshold-half-split
square=three-sigma-square
scaling() { echo "$1/early/$ours,$1/standard/$ours,$1/standard/per-pixel/$square"; }

# In which folders it was measured is nobody's business.
leave_folders_out() { sed -i "s|$out/||g;s|$scenes/||g" "$1"; }

# bench FILE ARGUMENT...: without members that are null or say that a frame had one view and colour alone, and without
# percentiles and counts that no table reads.
bench() {
  local file=$1
  shift
  echo "measure: $file" >&2
  "$swiftgs" bench "$@" --min-frames "$least" --max-frames "$most" --precision "$precision" --seed 1 \
    --json "$out/whole/$file" $resume
  cp "$out/whole/$file" "$out/$file"
  leave_folders_out "$out/$file"
  sed -Ei -e 's/,"[a-z_]+":null//g; s/"planes":"",//g; s/"batch":1,//g' \
    -e 's/,"p10":[^,}]+,"p90":[^,}]+//g' "$out/$file"
}

part_matrix() {
  local renderers=$backend/early/axis-shared-threshold-float-cholesky/obb sort bounds
  for bounds in $square opacity-box ellipse; do
    for sort in standard early; do renderers+=,$backend/$sort/*/$bounds; done
    renderers+=,$backend/adaptive/per-pixel/$bounds
  done
  renderers+=,$backend/adaptive/$paper/opacity-box,$backend/adaptive/axis-shared-threshold-float-cholesky/opacity-box
  bench matrix.json ${captures[@]+"${captures[@]}"} "${sizes_of_builtin[@]}" \
    --renderers "$renderers,$backend/adaptive/$ours" --views "$views" --errors 3
}

vanilla=$backend/standard/per-pixel/$square,$backend/adaptive/$paper/$square
vanilla+=,$backend/adaptive/axis-shared-threshold-float-cholesky/$square,$backend/adaptive/$ours
part_vanilla() {
  bench vanilla.json ${captures[@]+"${captures[@]}"} builtin --renderers "$vanilla" --conventions inria --views "$views" \
    --errors 3
}

part_gaussians() {
  [ ${#grown[@]} -eq 0 ] || bench scaling-gaussians.json "${grown[@]}" --renderers "$(scaling "$backend")" --views 0 \
    --gaussians 100000,250000,500000,1000000,2000000,4000000,8000000,12000000 --errors none
  bench scaling-builtin.json builtin:{100000,250000,500000,1000000,2000000,4000000,8000000,12000000} \
    --renderers "$(scaling "$backend")" --views 0 --errors none
}

# The sides' factors are those that make the images of garden, 1297x840, and of the built-in scene, 1280x720, grow from
# a quarter of a million pixels by about two to 33 million.
part_pixels() {
  bench scaling-pixels.json ${grown[@]+"${grown[@]}"} builtin:1000000 --renderers "$(scaling "$backend")" --views 0 \
    --scales 0.48,0.68,0.96,1.36,1.92,2.71,3.84,5.5 --errors none
}

part_threads() {
  local counts=1 count
  for count in 2 4 8 16; do [ "$count" -gt "$(nproc)" ] || counts+=,$count; done
  least=6 most=12 precision=0.02 bench scaling-threads.json ${captures[@]+"${captures[@]}"} builtin:1000000 \
    --renderers "$(scaling cpu)" --views 0 --threads "$counts" --errors none
}

part_occupancy() {
  bench scaling-occupancy.json ${grown[@]+"${grown[@]}"} builtin:1000000 --renderers "$(scaling "$backend")" --views 0 \
    --enlarge "$enlarge" --errors none
}

# Pruned scenes lie in OUTDIR/pruned, each a capture whose cameras and photos are links to those of the whole one.
# Whoever removes the folder removes links as links, `rm OUTDIR/pruned/*/photos` without a slash at the end, and follows
# none.
part_prune() {
  local capture name folder cameras photos pruned=()
  for capture in ${captures[@]+"${captures[@]}"}; do
    name=$(basename "$capture") folder=$out/pruned/$name-pruned
    cameras=$(part_of_capture "$capture" cameras) photos=$(part_of_capture "$capture" photos)
    mkdir -p "$folder"
    if [ -d "$cameras" ]; then ln -sfn "$cameras" "$folder/sparse"; else ln -sfn "$cameras" "$folder/cameras.json"; fi
    [ -z "$photos" ] || ln -sfn "$photos" "$folder/photos"
    "$swiftgs" prune "$capture" --keep 0.1 --score contribution --out "$folder/$name-pruned.ply"
    pruned+=("$folder")
  done
  [ ${#pruned[@]} -eq 0 ] || bench pruned.json "${pruned[@]}" --renderers "$vanilla" --conventions inria \
    --views "$views" --errors 1
}

# cameras_through LENS FROM TO: the cameras of a cameras.json through another lens, where they are.
cameras_through() {
  python3 - "$@" <<'END'
import json
import sys

MEMBERS = {"pinhole": {}, "opencv": {"camera_model": "OPENCV", "k1": 1e-7, "k2": 1e-7, "p1": 1e-7, "p2": 1e-7},
           "fisheye": {"camera_model": "OPENCV_FISHEYE"},
           "panorama": {"camera_model": "EQUIRECTANGULAR", "width": 2048, "height": 1024}}
lens, found, made = sys.argv[1:]
with open(found, encoding="utf-8") as file:
    cameras = json.load(file)
with open(made, "w", encoding="utf-8") as file:
    json.dump([{**camera, **MEMBERS[lens]} for camera in cameras], file)
END
}

# Captures lie in OUTDIR/lenses, one for each lens and order, with links to the scene in its two orders.
part_lenses() {
  local capture=${grown[0]:-} cameras order lens name folders=()
  cameras=$([ -z "$capture" ] || part_of_capture "$capture" cameras)
  [[ "$cameras" == */cameras.json ]] ||
    { echo "measure: '$capture': expected a capture with a cameras.json; lenses are not measured" >&2; return 0; }
  mkdir -p "$out/lenses"
  for order in '' -ordered; do
    "$swiftgs" convert "$capture" ${order:+--order} "$out/lenses/scene$order.ply"
    for lens in pinhole opencv fisheye panorama; do
      name=$(basename "$capture")-$lens$order
      mkdir -p "$out/lenses/$name"
      ln -sfn "../scene$order.ply" "$out/lenses/$name/$name.ply"
      cameras_through "$lens" "$cameras" "$out/lenses/$name/cameras.json"
      folders+=("$out/lenses/$name")
    done
  done
  bench lenses.json "${folders[@]}" --renderers "$backend/early/$ours" --views 0,3,6,9 --errors none
}

# The built-in scene lies in OUTDIR/harmonics.
part_harmonics() {
  local file kept files=()
  mkdir -p "$out/harmonics"
  for file in builtin-spz.spz builtin-sog.sog; do
    files+=("$out/harmonics/$file")
    "$swiftgs" convert "${sizes_of_builtin[-1]}" "${files[-1]}"
  done
  for kept in float smallest half; do
    bench "harmonics-$kept.json" ${captures[@]+"${captures[@]}"} "${sizes_of_builtin[-1]}" "${files[@]}" \
      --renderers "$backend/early/$ours" --views 0 --harmonics "$kept" --errors none
  done
}

# stress FILE ARGUMENT...: a ratio above 10 fails, and the file is kept, with six digits behind the point.
stress() {
  local file=$1 status=0
  shift
  "$swiftgs" stress "$@" --severity all --json "$out/$file" || status=$?
  [ ! -e "$out/$file" ] || { leave_folders_out "$out/$file" && sed -Ei 's/(\.[0-9]{6})[0-9]+/\1/g' "$out/$file"; }
  return $status
}

part_stress() {
  local renderers="$backend/early/*/ellipse" status=0
  stress stress.json --renderers "$renderers" --size 64x48 --seeds 16 || status=$?
  stress stress-large.json --renderers "$renderers" --families needles,ridges,mixtures --size 960x540,1920x1080 \
    --seeds 2 || status=$?
  return $status
}

failed=0 done=0
for part in "$@"; do
  started=$SECONDS
  set +e  # bash would ignore it in a command whose status is tested
  (set -e; "part_$part")
  status=$?
  set -e
  if [ $status -eq 0 ]; then
    done=$((done + 1))
    echo "measure: $part done in $((SECONDS - started)) s, $done of $# parts"
  else
    failed=1
    echo "measure: $part FAILED after $((SECONDS - started)) s" >&2
  fi
done
exit $failed
