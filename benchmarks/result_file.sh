#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Runs a program that prints rows, a JSON object a line, and prints a result file with them and the machine.
#   benchmarks/result_file.sh BUILD PROGRAM [ARGUMENT...]
# BUILD is the folder of the build, PROGRAM one that its folder benchmarks has, or in PATH.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
[ $# -ge 2 ] || { echo "usage: benchmarks/result_file.sh BUILD PROGRAM [ARGUMENT...]" >&2; exit 2; }
build=$1
shift
command="${*##*/}"
printf '{"format": "swiftgs-bench", "version": 1,\n"machine": %s,\n"command": "%s",\n' \
  "$("$here/describe_machine.sh" "$build" "$command")" "$command"
printf '"notes": [], "scenes": [], "views": [],\n"rows": [\n'
PATH=$build/benchmarks:$PATH "$@" | sed '$!s/$/,/'
echo ']}'
