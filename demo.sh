#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Installs what is missing, builds the command-line tool, and renders a scene.
#   ./demo.sh [SCENE]
# SCENE is a file of Gaussians or the folder of a capture; without one it is the built-in scene.
set -euo pipefail
[ $# -le 1 ] || { echo "usage: ./demo.sh [SCENE]" >&2; exit 2; }
scene=builtin
if [ $# -eq 1 ]; then
  [ -e "$1" ] || { echo "demo: $1: no such file; expected a file of Gaussians or the folder of a capture" >&2; exit 2; }
  scene=$(realpath "$1")
fi
cd "$(dirname "${BASH_SOURCE[0]}")"

cmake/setup.sh build
command -v ccache >/dev/null && export CMAKE_CXX_COMPILER_LAUNCHER=ccache
cmake --preset demo --log-level=WARNING
cmake --build --preset demo --parallel "$(nproc)"

out=$PWD/out/demo
build/demo/examples/swiftgs render "$scene" --views 0 --out "$out"
echo "demo: the image is $(ls -t "$out"/*.png | sed -n 1p); the line above says how long its frame took"
