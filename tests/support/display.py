# SPDX-License-Identifier: Apache-2.0
"""A screen of its own for programs that open windows."""
import contextlib
import os
import pathlib
import struct
import subprocess


@contextlib.contextmanager
def display(xvfb, *arguments):
    """The environment of programs on the screen, drawn on the processor."""
    server = subprocess.Popen([xvfb, "-displayfd", "1", "-screen", "0", "1280x1024x24", "-nolisten", "tcp", *arguments],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        number = server.stdout.readline().strip()
        yield {**os.environ, "DISPLAY": f":{number}", "LIBGL_ALWAYS_SOFTWARE": "1",
               "ASAN_OPTIONS": "detect_leaks=0"}  # drivers leak
    finally:
        server.terminate()
        server.communicate()


def screen(folder):
    """What shows on the screen of `-fbdir folder`, row by row; each pixel is blue, green, red and a filler."""
    dump = (pathlib.Path(folder) / "Xvfb_screen0").read_bytes()  # an XWD file
    head = struct.unpack(">25I", dump[:100])
    size, width, height, stride, colours = head[0], head[4], head[5], head[12], head[19]
    first = size + 12 * colours
    return [dump[first + stride * y:first + stride * y + 4 * width] for y in range(height)]


def without_display():
    return {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
