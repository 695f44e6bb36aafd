#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Checks a release beyond what ./test.sh has time for. Works in build/release_check, says what is skipped and why, and
# ends with one line, 'N passed, N failed, N skipped'. Fresh systems need root and the mirrors of Debian and Ubuntu.
#   cmake/release_check.sh                       packages, wheel and reproducible
#   cmake/release_check.sh packages              Debian packages: built, checked, and used in fresh systems
#   cmake/release_check.sh wheel                 the Python wheel: built, and used in fresh systems
#   cmake/release_check.sh cuda                  packages and wheel with CUDA, used where there is no driver, and sizes;
#                                                CUDAARCHS=90 builds them for these GPUs alone
#   cmake/release_check.sh reproducible          the libraries and the wheel have the same bytes wherever they are built
#   cmake/release_check.sh arm64                 tests of hosts, cross-compiled and run by qemu
#   cmake/release_check.sh compilers             other compilers build what is for hosts without a warning, and tests pass
#   cmake/release_check.sh fuzz SECONDS          every fuzz target for SECONDS; writes executions and coverage
set -uo pipefail
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=$source/build/release_check
roots=$out/roots  # fresh systems: made and removed here alone
cd "$source" && cmake/setup.sh release && mkdir -p "$out" || exit 1

# NAME SUITE SCRIPT MIRROR: fresh systems. Debian 12 has no debootstrap script for Ubuntu 24.04, but one is the same for
# all of Ubuntu.
systems='debian-12 bookworm bookworm http://deb.debian.org/debian
debian-13 trixie trixie http://deb.debian.org/debian
ubuntu-24.04 noble gutsy http://archive.ubuntu.com/ubuntu'
names='debian-12 ubuntu-24.04'  # those that packages are tested on
# NAME CC CXX ARCHIVE: what else builds SwiftGS, with CMake of that archive of the system. That of backports is 4.
compilers='debian-13 gcc g++ trixie-backports
debian-13 clang clang++ trixie
ubuntu-24.04 clang clang++ noble'
export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
here=$(. /etc/os-release && echo "$ID-$VERSION_ID")

passed=0 failed=0 skipped=0
check() {  # check NAME COMMAND...: its words go to a file
  local log=$out/${1//[^A-Za-z0-9.]/-}.log
  if "${@:2}" >"$log" 2>&1; then
    echo "ok: $1"
    passed=$((passed + 1))
  else
    echo "FAILED: $1; see $log"
    tail -n 5 "$log"
    failed=$((failed + 1))
    return 1
  fi
}
skip() {  # skip NAME REASON
  echo "skipped: $1: $2"
  skipped=$((skipped + 1))
}

# The one line that removes folders: those of these names, which this script has made.
remove() {
  case $1 in
    debian-12 | debian-12-arm64 | debian-12-build | debian-13-build | ubuntu-24.04 | ubuntu-24.04-build | elsewhere) ;;
    *) echo "release_check: expected a system's name, found '$1'" >&2; exit 1 ;;
  esac
  rm -rf --one-file-system "$source/build/release_check/roots/$1"
}

# make_root NAME [FOLDER]: a fresh minimal system in the folder of that name.
make_root() {
  local folder=${2:-$1} keys=/usr/share/keyrings/${1%%-*}-archive-keyring.gpg suite script mirror
  read -r _ suite script mirror < <(grep "^$1 " <<<"$systems")
  remove "$folder"
  mkdir -p "$roots"
  debootstrap --variant=minbase --components=main,universe --keyring="$keys" "$suite" "$roots/$folder" "$mirror" \
    "/usr/share/debootstrap/scripts/$script"
}

# Why no fresh system of that name can be made; nothing where it can.
missing_for_root() {
  local suite mirror keys=/usr/share/keyrings/${1%%-*}-archive-keyring.gpg
  read -r _ suite _ mirror < <(grep "^$1 " <<<"$systems")
  if [ "$(id -u)" -ne 0 ]; then echo "root makes fresh systems"
  elif ! command -v debootstrap >/dev/null; then echo "no debootstrap here (package debootstrap)"
  elif [ ! -e "$keys" ]; then echo "no $keys here"
  elif ! /usr/lib/apt/apt-helper download-file "$mirror/dists/$suite/Release" "$out/$1.release" >/dev/null 2>&1; then
    echo "$mirror is out of reach"
  fi
}

has_nvcc() { command -v nvcc >/dev/null || [ -x /usr/local/cuda/bin/nvcc ]; }

# inside FOLDER COMMAND...: in that system, with terminals; its mounts end with the command.
inside() {
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
    CMAKE_BUILD_PARALLEL_LEVEL="$CMAKE_BUILD_PARALLEL_LEVEL" \
    unshare --mount --pid --fork --mount-proc="$roots/$1/proc" bash -ec '
      mount --bind /dev/pts "$0/dev/pts"
      exec chroot "$0" "$@"' "$roots/$1" "${@:2}"
}

# The same, where qemu runs programs for arm64: the kernel knows its name until the command ends.
emulated() {
  local magic='\x7fELF\x02\x01\x01\x00\x00\x00\x00\x00\x00\x00\x00\x00\x02\x00\xb7\x00'
  local mask='\xff\xff\xff\xff\xff\xff\xff\x00\xff\xff\xff\xff\xff\xff\xff\xff\xfe\xff\xff\xff'
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
    CMAKE_BUILD_PARALLEL_LEVEL="$CMAKE_BUILD_PARALLEL_LEVEL" CTEST_PARALLEL_LEVEL="$CMAKE_BUILD_PARALLEL_LEVEL" \
    CMAKE_TOOLCHAIN_FILE=/swiftgs/cmake/arm64.cmake \
    PKG_CONFIG_LIBDIR=/usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig \
    unshare --user --map-root-user --mount --pid --fork --mount-proc="$roots/$1/proc" bash -ec '
      mount --rbind /dev/pts "$0/dev/pts"
      mount -t binfmt_misc none "$0/proc/sys/fs/binfmt_misc"
      echo "$1" >"$0/proc/sys/fs/binfmt_misc/register"
      exec chroot "$0" "${@:2}"' \
    "$roots/$1" ":arm64:M::$magic:$mask:$roots/$1/usr/bin/qemu-aarch64-static:F" "${@:2}"
}

copy_sources() {  # copy_sources FOLDER
  mkdir -p "$1"
  git ls-files -z --cached --others --exclude-standard | tar --null -T - -c --ignore-failed-read | tar -x -C "$1"
}

build_packages() {  # build_packages FOLDER [CUDA]: also run within other systems, where $source is another folder
  cmake --preset distribution -B "$1" -DSWIFTGS_BUILD_CUDA="${2:-OFF}" && cmake --build "$1" &&
    (cd "$1" && rm -f packages/*.deb && cpack -B packages)
}

build_packages_in() {  # build_packages_in NAME FOLDER: what they need is installed from cmake/packages.txt
  make_root "$1" "$1-build" && copy_sources "$roots/$1-build/swiftgs" &&
    inside "$1-build" bash -ec "cd /swiftgs; apt-get -q update; apt-get -q install -y dpkg-dev file python3
      cmake/setup.sh build; $(declare -f build_packages); build_packages /swiftgs/build/packages" &&
    mkdir -p "$2/packages" && cp "$roots/$1-build/swiftgs/build/packages/packages"/*.deb "$2/packages"
}

no_file_twice() {  # no_file_twice PACKAGE...
  local twice
  twice=$(for package; do dpkg-deb --fsys-tarfile "$package" | tar -t; done | grep -v '/$' | sort | uniq -d)
  [ -z "$twice" ] || { echo "in two packages: $twice"; return 1; }
}

use_packages() {  # use_packages NAME FOLDER [cuda]: what people do with them, in a fresh system
  make_root "$1" && mkdir -p "$roots/$1/check" &&
    cp -r "$2/packages"/*.deb tests/install/consumer tests/install/c_consumer examples/00_readme.cpp \
      examples/07_c_render.c "$roots/$1/check" &&
    cp cmake/release_use.sh "$roots/$1/check/" && inside "$1" env ${3:+CUDA=1} bash /check/release_use.sh packages
}

packages() {
  local name reason folder
  for name in $names; do
    reason=$(missing_for_root "$name")
    folder=$out/$name
    if [ "$name" = "$here" ]; then
      check "packages of $name: they build" build_packages "$folder" || continue
    elif [ -n "$reason" ]; then
      skip "packages of $name" "$reason"
      continue
    else
      check "packages of $name: they build in a fresh system" build_packages_in "$name" "$folder" || continue
      remove "$name-build"
    fi
    check "packages of $name: no file is in two" no_file_twice "$folder/packages"/*.deb
    if command -v lintian >/dev/null; then
      check "packages of $name: lintian finds no error" lintian --allow-root --fail-on error "$folder/packages"/*.deb
    else
      skip "packages of $name: lintian" "no lintian here (package lintian)"
    fi
    if [ -n "$reason" ]; then
      skip "packages of $name: use" "$reason"
    else
      check "packages of $name: C++ and C and Python and the tool in a fresh system" \
        use_packages "$name" "$folder"
      remove "$name"
    fi
  done
}

build_wheel() {  # build_wheel SOURCES BUILD FOLDER [CUDA]
  (cd "$1" && cmake --preset distribution -B "$2" -DBUILD_SHARED_LIBS=OFF -DSWIFTGS_BUILD_CUDA="${4:-OFF}" \
    -DSWIFTGS_BUILD_EXAMPLES=OFF && cmake --build "$2" && rm -f "$3"/*.whl &&
    python3 backends/bindings/python/wheel.py "$2" "$3")
}

use_wheel() {  # use_wheel NAME FOLDER [cuda]
  make_root "$1" && mkdir -p "$roots/$1/check" &&
    cp "$2"/*.whl cmake/release_use.sh "$roots/$1/check" && inside "$1" env ${3:+CUDA=1} bash /check/release_use.sh wheel
}

wheel() {
  local name reason
  check "wheel: it builds and loads nothing but its own and what every Linux has" \
    build_wheel "$source" "$out/wheel" "$out/dist" || return
  for name in $names; do
    reason=$(missing_for_root "$name")
    if [ -n "$reason" ]; then
      skip "wheel: $name" "$reason"
    else
      check "wheel: it draws on a fresh $name" use_wheel "$name" "$out/dist"
      remove "$name"
    fi
  done
}

# With CUDA: nobody needs a GPU to install what is made here, or to draw with it on a processor.
cuda() {
  local reason file
  if ! has_nvcc; then
    skip cuda "no nvcc here"
    return
  fi
  reason=$(missing_for_root "$here")
  check "cuda: packages build" build_packages "$out/cuda" ON || return
  check "cuda: no file is in two packages" no_file_twice "$out/cuda/packages"/*.deb
  check "cuda: the wheel builds and needs no driver to load" \
    build_wheel "$source" "$out/cuda-wheel" "$out/cuda-dist" ON || return
  if [ -n "$reason" ]; then
    skip "cuda: use" "$reason"
  else
    check "cuda: packages install and draw in a fresh $here" use_packages "$here" "$out/cuda" cuda
    check "cuda: the wheel draws in a fresh $here" use_wheel "$here" "$out/cuda-dist" cuda
    remove "$here"
  fi
  {
    echo "| GPUs | file | MB |"
    echo "| --- | --- | ---: |"
    for file in "$out/cuda/packages"/*.deb "$out/cuda-dist"/*.whl "$out"/cuda/backends/cuda/libswiftgs_cuda.so.*.*.*; do
      printf '| %s | %s | %.1f |\n' "${CUDAARCHS:-all kinds}" "${file##*/}" "$(stat -c %s "$file")e-6"
    done
  } | tee "$out/cuda.md"
}

same_bytes() {
  local again=$roots/elsewhere/sources dist=$roots/elsewhere/dist file other count=0
  remove elsewhere
  copy_sources "$again" && CCACHE_DISABLE=1 build_wheel "$again" "$again/build/again" "$dist" || return 1
  for file in "$out/wheel"/backends/{,*/,*/*/}*.a "$out/wheel"/backends/bindings/c/*.so.*.* "$out/dist"/*.whl; do
    other=$again/build/again${file#"$out/wheel"}
    [ "$file" = "${file#"$out/dist"}" ] || other=$dist${file#"$out/dist"}
    cmp "$file" "$other" || return 1
    count=$((count + 1))
  done
  [ "$count" -eq 7 ]  # five libraries of C++, the C interface, and the wheel
}

reproducible() {
  check "reproducible: a build to compare with" build_wheel "$source" "$out/wheel" "$out/dist" || return
  check "reproducible: another folder gives the same bytes" same_bytes
  remove elsewhere
}

# Why qemu cannot run programs of the fresh system as if they were this machine's; nothing where it can.
missing_for_arm64() {
  missing_for_root debian-12
  unshare --user --map-root-user --mount mount -t binfmt_misc none /proc/sys/fs/binfmt_misc 2>/dev/null ||
    echo "the kernel lets no user namespace have a binfmt_misc of its own (6.7 does)"
}

make_arm64_root() {
  local needs
  needs=$(awk '!/^#/ && $2 == "build" && $1 ~ /^lib|-dev$/ { print $1 }' cmake/packages.txt | paste -sd ,)
  make_root debian-12 debian-12-arm64 && copy_sources "$roots/debian-12-arm64/swiftgs" &&
    inside debian-12-arm64 bash -ec "dpkg --add-architecture arm64; apt-get -q update
      apt-get -q install -y --no-install-recommends cmake ninja-build g++-aarch64-linux-gnu pkg-config qemu-user-static
      apt-get -q satisfy -y --no-install-recommends --host-architecture arm64 '$needs,doctest-dev'"
}

arm64() {
  local reason root=debian-12-arm64
  reason=$(missing_for_arm64 | sed -n 1p)
  [ -z "$reason" ] || { skip arm64 "$reason"; return; }
  check "arm64: a fresh system with a cross compiler" make_arm64_root &&
    # Tests are asked for their names where they are built.
    check "arm64: all builds" emulated "$root" bash -ec 'cd /swiftgs
      cmake --preset release -DSWIFTGS_BUILD_CUDA=OFF -DSWIFTGS_BUILD_MPI=OFF -DSWIFTGS_BUILD_BENCHMARKS=OFF
      cmake --build --preset release' &&
    check "arm64: the tests pass" emulated "$root" env QEMU_CPU=cortex-a72 ctest --test-dir /swiftgs/build/release &&
    remove "$root"
}

# Builds and tests with a compiler in a fresh system, and a program of installed libraries in C++20 and 23. Leaves a row
# of the versions found.
build_with() {  # build_with NAME CC CXX ARCHIVE
  local root=$1-build mirror
  read -r _ _ _ mirror < <(grep "^$1 " <<<"$systems")
  make_root "$1" "$root" && copy_sources "$roots/$root/swiftgs" &&
    echo "deb $mirror $4 main universe" >"$roots/$root/etc/apt/sources.list.d/cmake.list" &&
    inside "$root" env CC="$2" CXX="$3" bash -ec '
      cd /swiftgs; apt-get -q update; cmake/setup.sh build
      apt-get -q install -y --no-install-recommends doctest-dev clang libclang-rt-dev python3
      apt-get -q install -y --no-install-recommends --target-release "$2" cmake
      cmake --preset release -DSWIFTGS_BUILD_CUDA=OFF -DSWIFTGS_BUILD_MPI=OFF -DSWIFTGS_BUILD_BENCHMARKS=OFF
      cmake --build --preset release
      ctest --preset release
      cmake --install build/release --prefix /installed
      for standard in 20 23; do
        cmake -G Ninja -S tests/install/consumer -B "/consumer$standard" -DCMAKE_PREFIX_PATH=/installed \
          -DCMAKE_CXX_STANDARD=$standard -DCMAKE_CXX_STANDARD_REQUIRED=ON
        cmake --build "/consumer$standard"
        (cd "/consumer$standard" && ./consumer)
      done
      library=$(echo "#include <version>" | $CXX -std=c++20 -x c++ -dM -E - | awk "/ _GLIBCXX_RELEASE / { print \$3 }")
      echo "| $1 | $($CXX --version | sed -n 1p) | $library | $(cmake --version | sed -n 1p) |" >/row' - "$1" "$4" &&
    cat "$roots/$root/row" >>"$out/compilers.rows"
}

compilers() {
  local name cc cxx archive reason
  rm -f "$out/compilers.rows"
  while read -r name cc cxx archive; do
    reason=$(missing_for_root "$name")
    if [ -n "$reason" ]; then
      skip "compilers: $cxx of $name" "$reason"
    else
      check "compilers: $cxx of $name builds what is for hosts, and tests and programs in C++20 and 23 pass" \
        build_with "$name" "$cc" "$cxx" "$archive" </dev/null && remove "$name-build"
    fi
  done <<<"$compilers"
  [ ! -e "$out/compilers.rows" ] || {
    echo "| system | compiler | libstdc++ | CMake |"
    echo "| --- | --- | --- | --- |"
    cat "$out/compilers.rows"
  } | tee "$out/compilers.md"
}

# One target for SECONDS; writes a line of the table: executions, edges reached and edges in the program.
fuzz_target() {  # fuzz_target PROGRAM SECONDS
  local name folder
  name=$(basename "$1")
  folder=$(dirname "$1")
  mkdir -p "$folder/${name}_corpus"
  "$1" -max_total_time="$2" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 -artifact_prefix="$folder/$name-" \
    "$folder/${name}_corpus" tests/fuzz/seeds/"${name#fuzz_}" >"$out/$name.log" 2>&1 || return 1
  awk -v name="${name#fuzz_}" '
    /^INFO: Loaded .*counters/ { match($0, /\([0-9]+ inline/); all = substr($0, RSTART + 1, RLENGTH - 8) }
    /cov: [0-9]+ ft: [0-9]+/ { for (i = 1; i < NF; ++i) { if ($i == "cov:") cov = $(i + 1)
                                                          if ($i == "ft:") ft = $(i + 1) }
                               if (cov != last) { last = cov; split($1, at, "#"); grown = at[2] } }
    /^stat::number_of_executed_units/ { executions = $2 }
    END { printf "| %s | %d | %d | %d | %d | %d |\n", name, executions, cov, all, ft, grown }' "$out/$name.log" \
    >"$out/$name.row"
}

fuzz() {  # fuzz SECONDS
  local target
  command -v clang++ >/dev/null || { skip fuzz "no clang++ here (package clang)"; return; }
  check "fuzz: the targets build" bash -c 'cmake --preset fuzz && cmake --build --preset fuzz' || return
  rm -f "$out"/fuzz_*.row
  for target in build/fuzz/tests/fuzz/fuzz_*; do
    [ -f "$target" ] && [ -x "$target" ] || continue
    check "fuzz: $(basename "$target") survives $1 seconds" fuzz_target "$target" "$1"
  done
  {
    echo "| target | executions | edges reached | edges | features | execution that last reached a new edge |"
    echo "| --- | ---: | ---: | ---: | ---: | ---: |"
    cat "$out"/fuzz_*.row
  } | tee "$out/fuzz.md"
}

case "${1:-all}" in
  all) packages; wheel; reproducible ;;
  packages | wheel | cuda | reproducible | arm64 | compilers) "$1" ;;
  fuzz)
    [[ "${2:-}" =~ ^[1-9][0-9]*$ ]] || { echo "usage: cmake/release_check.sh fuzz SECONDS" >&2; exit 2; }
    fuzz "$2" ;;
  *) sed -n 's/^#   //p' "$0" >&2; exit 2 ;;
esac
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
