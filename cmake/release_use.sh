#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# Run by release_check.sh within a fresh system: uses the packages or the wheel in /check as people do.
set -euxo pipefail
cd /check
install() { apt-get -q install -y --no-install-recommends "$@"; }
apt-get -q update

draw_in_python() {  # draw_in_python INTERPRETER
  "$1" - <<'END'
import swiftgs

frame = swiftgs.Renderer(scene=swiftgs.Scene.builtin(3000)).render(swiftgs.Camera.builtin())
assert 0.1 < frame.colour.mean() < 0.9
frame.save("python.png")
print("swiftgs", swiftgs.__version__, "of", swiftgs.__file__)
END
  test -s python.png
}

# refused COMMAND...: renderers of CUDA are known where there is no driver, and one line says that they cannot run.
refused() {
  test ! -e /dev/nvidiactl
  if "$@" 2>refused; then exit 1; fi
  grep "renderer 'cuda/.*' cannot run on this machine" refused
}

if [ "$1" = wheel ]; then
  install python3 python3-venv python3-numpy
  # None but the wheel's own.
  test -z "$(ls /usr/lib/*/libtbb.so* /usr/lib/*/libpng*.so* /usr/lib/*/libhwy.so* 2>/dev/null || true)"
  python3 -m venv --system-site-packages venv  # NumPy is the system's
  venv/bin/pip install --no-index --no-deps ./*.whl
  cd /
  draw_in_python /check/venv/bin/python
  if [ -n "${CUDA:-}" ]; then refused /check/venv/bin/python -c 'import swiftgs; swiftgs.Renderer("cuda")'; fi
  exit
fi

# What programs load comes without what they are built with.
install ./swiftgs_*.deb ./python3-swiftgs_*.deb ./libswiftgs[0-9]*_*.deb ./libswiftgs-c[0-9]*_*.deb \
  ${CUDA:+./libswiftgs-cuda*_*.deb}
test ! -e /usr/include/swiftgs
swiftgs --version
swiftgs render builtin:3000 --views 1 --scale 0.25 --out images
test -n "$(ls images/*.png)"
draw_in_python python3
if [ -n "${CUDA:-}" ]; then
  refused swiftgs render builtin:3000 --renderer cuda/early/axis-shared-threshold-float-cholesky/ellipse --out images
fi

install ./libswiftgs-dev_*.deb cmake make g++ pkg-config
version=$(swiftgs --version | sed 's/^swiftgs //')
cmake -S consumer -B consumer/build -DSWIFTGS_VERSION="$version"
cmake --build consumer/build
(cd consumer/build && ./consumer)
cmake -S c_consumer -B c_consumer/build -DSWIFTGS_VERSION="$version" -DSOURCE=/check/07_c_render.c
cmake --build c_consumer/build
c++ -std=c++20 00_readme.cpp -o readme $(pkg-config --cflags --libs swiftgs-builtin swiftgs-cpu swiftgs-io)
./readme
cc -std=c11 07_c_render.c -o c_render $(pkg-config --cflags --libs swiftgs-c) -lm
rm frame.png
./c_render
test -s frame.png
test "$(pkg-config --modversion swiftgs-c)" = "$version"

apt-get -q purge -y '~nswiftgs'
test ! -e /usr/include/swiftgs -a ! -e /usr/bin/swiftgs -a ! -e /usr/lib/python3/dist-packages/swiftgs
