#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Installs what is missing, and builds the documentation site: docs/site.sh [FOLDER]. Fails where doxygen warns.
# SITE_SOURCES is an address below which the sources can be read; without it, links to them lead to this folder.
# SWIFTGS_TOOL is the command-line tool whose help is a page; without it, that is the newest one below build.
set -euo pipefail
root=$(realpath "$(dirname "${BASH_SOURCE[0]}")/..")
out=$(realpath -m "${1:-$root/build/site}")
cd "$root"

cmake/setup.sh docs
mkdir -p "$out"
sources=${SITE_SOURCES:-$(realpath --relative-to="$out" .)}
inputs=$(python3 -B docs/site/write.py "$out/written" "$sources")

awesome=/usr/share/doxygen-awesome-css
styles=docs/site/site.css
[ ! -d "$awesome" ] || styles="$awesome/doxygen-awesome.css $awesome/doxygen-awesome-sidebar-only.css $styles"
doxygen - <<END
@INCLUDE = Doxyfile
PROJECT_NUMBER = $(sed -n 's/.* version = "\(.*\)".*/\1/p' include/swiftgs/version.hpp)
INPUT = ${inputs//$'\n'/ }
STRIP_FROM_PATH = "$out/written"
STRIP_FROM_INC_PATH = "$out/written/include"
USE_MDFILE_AS_MAINPAGE = "$out/written/README.md"
OUTPUT_DIRECTORY = "$out"
HTML_EXTRA_STYLESHEET = $styles
END
echo "site: open $out/index.html"
