# SPDX-License-Identifier: Apache-2.0
"""Time against error: which renderers no other beats in both."""
from tables.frames import Frames, label
from tables.markdown import decibel, ms, prose, table
from tables.source import machine_name


def on_front(found):
    """Names of {name: (milliseconds, dB)} that no other beats in both, from the fastest on."""
    best, front = None, []
    for name, (_, psnr) in sorted(found.items(), key=lambda one: (one[1][0], -one[1][1])):
        if best is None or psnr > best:
            best, front = psnr, front + [name]
    return front


def pareto(source, machine):
    """The front of each scene, with what was measured beside it counted."""
    frames, rows, left_out = Frames(source.results(machine, "matrix.json")), [], False
    for scene in frames.scenes:
        names = [name for of, name in frames.of if of == scene]
        found = {name: (frames.mean(scene, name), frames.worst_psnr(scene, name)) for name in names}
        judged = {name: values for name, values in found.items() if None not in values}
        left_out |= len(judged) < len(found)
        rows += [[label(scene), f"`{name}`", ms(judged[name][0]), decibel(judged[name][1]), str(len(judged))]
                 for name in on_front(judged)]
    words = "" if not left_out else " Renderers that were not compared with float64 are left out."
    return (prose(f"{machine_name(frames.results)}, `{frames.backend}`: renderers that none of those measured beats in "
                  f"both, milliseconds a frame as means over views and PSNR against float64 in the worst view.{words}")
            + "\n\n" + table(["scene", "sort/raster/bounds", "ms", "dB", "of renderers"], rows, words=2))


TABLES = {"pareto": pareto}
