#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Installs what is missing of cmake/packages.txt; does nothing, and needs no network, when nothing is.
#   cmake/setup.sh build    what the library, the command-line tool and the demo need
#   cmake/setup.sh docs     what docs/site.sh needs
#   cmake/setup.sh test     all of that, and what ./test.sh needs
#   cmake/setup.sh release  all of that, and what cmake/release_check.sh needs
# Fails where something that is needed cannot be installed; what is optional is only said to be missing.
# SWIFTGS_SKIP_SETUP=1 leaves the system alone: for libraries that come from elsewhere.
set -euo pipefail

list=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/packages.txt
case "${1:-}" in
  build) parts='^build[?]?$' ;;
  docs) parts='^docs[?]?$' ;;
  test) parts='^(build|docs|test)[?]?$' ;;
  release) parts='^(build|docs|test|release)[?]?$' ;;
  *) echo "usage: cmake/setup.sh build|docs|test|release" >&2; exit 2 ;;
esac
[ "${SWIFTGS_SKIP_SETUP:-0}" = 1 ] && exit 0

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  echo "setup: expected Debian 12, Ubuntu 24.04 or newer. Install the equivalents of the packages in $list," \
       "then run again with SWIFTGS_SKIP_SETUP=1." >&2
  exit 1
fi

missing=() optional=()
while read -r name part; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$name" 2>/dev/null || true)
  [ "$status" = installed ] && continue
  case $part in *'?') optional+=("$name") ;; *) missing+=("$name") ;; esac
done < <(awk -v parts="$parts" '!/^#/ && NF && $2 ~ parts { print $1, $2 }' "$list")

# What is optional costs no network where the system knows of no such package. awk reads to the end: a reader that
# leaves early kills apt-cache by SIGPIPE, and pipefail would make that the answer.
has_candidate() { LC_ALL=C apt-cache policy "$1" | awk '/^ *Candidate: [^(]/ { found = 1 } END { exit !found }'; }
if [ ${#missing[@]} -eq 0 ]; then
  known=()
  for name in ${optional[@]+"${optional[@]}"}; do
    if has_candidate "$name"; then known+=("$name"); else echo "setup: there is no package $name here"; fi
  done
  optional=(${known[@]+"${known[@]}"})
fi
[ $((${#missing[@]} + ${#optional[@]})) -eq 0 ] && exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "setup: expected root or sudo to install: ${missing[*]} ${optional[*]}" >&2
    [ ${#missing[@]} -eq 0 ]  # without what is optional all else can go on
    exit
  fi
  as_root=(sudo)
fi
wait_for_lock=(-o DPkg::Lock::Timeout=300)
install() {
  echo "setup: installing $*"
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get "${wait_for_lock[@]}" -q install -y --no-install-recommends "$@"
}
if ! "${as_root[@]}" apt-get "${wait_for_lock[@]}" -q update; then
  if [ ${#missing[@]} -gt 0 ]; then
    echo "setup: apt-get update failed; expected a network to install ${missing[*]} from" >&2
    exit 1
  fi
  echo "setup: apt-get update failed; going on without ${optional[*]}, which is optional"
  exit 0
fi
[ ${#missing[@]} -eq 0 ] || install "${missing[@]}"
for name in ${optional[@]+"${optional[@]}"}; do
  if ! has_candidate "$name"; then
    echo "setup: there is no package $name here"
  elif ! install "$name"; then
    echo "setup: $name cannot be installed; going on without it, it is optional"
  fi
done
