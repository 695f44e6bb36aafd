#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Installs what is missing, builds the command-line tool, and renders the built-in scene.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

cmake/setup.sh build
command -v ccache >/dev/null && export CMAKE_CXX_COMPILER_LAUNCHER=ccache
cmake --preset demo --log-level=WARNING
cmake --build --preset demo --parallel "$(nproc)"

out=$PWD/out/demo
build/demo/examples/swiftgs render builtin --out "$out"
echo "demo: the image is $(ls "$out"/*.png); the line above says how long its frame took"
