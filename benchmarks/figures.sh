#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Saves the plots of a page of `swiftgs report` as SVG files on a white ground: pareto-SCENE.svg, stages-SCENE.svg and
# speedup-SCENE.svg, with the backend behind the scene where the page has several; scaling-gaussians-SCENE.svg,
# scaling-pixels-SCENE.svg, scaling-threads-SCENE.svg and scaling-occupancy-SCENE.svg; of hard frames
# stability-cpu.svg, stability-serial.svg and stability-gpu.svg.
#   benchmarks/figures.sh REPORT.html FOLDER
# Chromium draws them: `chromium` or its like in PATH, or the program that SWIFTGS_BROWSER names. Its profile, some
# megabytes in a new folder for temporary files, is left there, and the last line says where.
set -euo pipefail
[ $# -eq 2 ] || { echo "usage: benchmarks/figures.sh REPORT.html FOLDER" >&2; exit 2; }
report=$1 folder=$2
[ -r "$report" ] || { echo "figures: $report: expected a page of swiftgs report" >&2; exit 1; }

browser=${SWIFTGS_BROWSER:-}
for name in chromium chromium-headless-shell google-chrome; do
  [ -n "$browser" ] || browser=$(command -v "$name" || true)
done
[ -n "$browser" ] || { echo "figures: expected chromium, chromium-headless-shell or google-chrome in PATH" >&2; exit 1; }

place=$(mktemp -d)
cp "$report" "$place/report.html"
timeout 300 "$browser" --headless --no-sandbox --disable-gpu --user-data-dir="$place/profile" \
  --virtual-time-budget=60000 --dump-dom "file://$place/report.html#figures" >"$place/drawn.html" 2>"$place/log" ||
  { echo "figures: $browser failed: $(tail -n 1 "$place/log")" >&2; exit 1; }
grep -q 'id="figures"' "$place/drawn.html" ||
  { echo "figures: $report: expected a page of swiftgs report that draws without a fault" >&2; exit 1; }

mkdir -p "$folder"
sed -n 's/.*<p data-figure="\([^"]*\)">\([^<]*\)<.*/\1 \2/p' "$place/drawn.html" | while read -r name content; do
  base64 -d <<<"$content" >"$folder/$name.svg"
  echo "$folder/$name.svg"
done
rm "$place/report.html" "$place/drawn.html" "$place/log"
echo "figures: the browser's profile is left in $place" >&2
