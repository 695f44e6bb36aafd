#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""usage: find_slowdown.py COMPARE FOLDER

Asks COMPARE what moved between before.json and after.json in FOLDER, of which the second rasterizes 5 % slower, and
fails unless it is the rasterization with what holds it, and nothing else.
"""
import subprocess
import sys

compare, folder = sys.argv[1:]
run = subprocess.run([sys.executable, "-B", compare, f"{folder}/before.json", f"{folder}/after.json"],
                     capture_output=True, text=True, check=False)
print(run.stdout, run.stderr)
named = {stage for stage in ("project", "sort", "raster", "total", "wall")
         for line in run.stdout.splitlines() if line.startswith("|") and f"| {stage} |" in line.replace("`", "")}
if run.returncode != 1:
    sys.exit(f"expected exit code 1, something is slower; got {run.returncode}")
if "raster" not in named:
    sys.exit("the slower rasterization was not found")
if named & {"project", "sort"}:
    sys.exit(f"expected nothing but raster, total and wall; named were {sorted(named)}")
