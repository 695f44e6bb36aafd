# SPDX-License-Identifier: Apache-2.0
"""A screen of its own for programs that open windows."""
import contextlib
import os
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


def without_display():
    return {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
