# SPDX-License-Identifier: Apache-2.0
"""Frames of scenes whose spherical harmonics are kept in several forms."""
from tables.frames import Frames, label
from tables.growth import BEST
from tables.markdown import ms, table
from tables.source import backend, machine_name

KEPT = ("float", "smallest", "half")


def harmonics(source, machine):
    """Memory, sort and frame of each scene with floats, and both times with other forms over those."""
    files = [source.results(machine, f"harmonics-{kept}.json") for kept in KEPT]
    floats, smallest, halves = map(Frames, files)
    rows = []
    for scene in floats.scenes:
        of_floats = floats.rows(scene, BEST)[0]
        bytes_of = "device_bytes" if backend(machine) == "cuda" else "host_bytes"
        row = [label(scene), f"{floats.needed(of_floats, bytes_of) / 1e6:.0f}",
               ms(floats.mean(scene, BEST, "sort")), ms(floats.mean(scene, BEST))]
        row.append(smallest.rows(scene, BEST)[0].harmonics)
        for frames in (smallest, halves):
            kept = frames.rows(scene, BEST)[0]
            row += [f"{frames.needed(kept, bytes_of) / 1e6:.0f}",
                    f"{frames.mean(scene, BEST, 'sort') / floats.mean(scene, BEST, 'sort'):.2f}",
                    f"{frames.mean(scene, BEST) / floats.mean(scene, BEST):.2f}"]
        rows.append(row)
    return (f"{machine_name(files[0])}, `{BEST}`, first views; megabytes of renderer and scene, milliseconds with "
            "floats, and times over these:\n\n" + table(
                ["scene", "floats, MB", "sort, ms", "frame, ms", "smallest", "MB", "sort", "frame", "halves, MB",
                 "sort", "frame"], rows))


TABLES = {"harmonics": harmonics}
