# SPDX-License-Identifier: Apache-2.0
"""Frames of scenes whose spherical harmonics are kept in several forms."""
from tables.frames import Frames, label
from tables.growth import BEST
from tables.markdown import ms, quotient, table
from tables.results import InputError
from tables.source import machine_name

KEPT = ("float", "smallest", "half")


def harmonics(source, machine):
    """Sort and frame of each scene with floats, and with other forms over these."""
    files = [source.results(machine, f"harmonics-{kept}.json") for kept in KEPT]
    floats, *others = map(Frames, files)
    for frames in others:
        if frames.scenes != floats.scenes:
            raise InputError(f"{floats.results.path}: expected the scenes of {frames.results.path}")
    rows = []
    for scene in floats.scenes:
        row = [label(scene), others[0].first_row(scene, BEST).harmonics]
        row += [ms(floats.mean(scene, BEST, stage)) for stage in ("sort", "total")]
        row += [quotient(frames.mean(scene, BEST, stage), floats.mean(scene, BEST, stage))
                for frames in others for stage in ("sort", "total")]
        rows.append(row)
    return (f"{machine_name(files[0])}, `{BEST}`, first views: milliseconds with floats, and times over these:\n\n"
            + table(["scene", "smallest form", "sort, floats", "frame, floats", "sort, smallest", "frame, smallest",
                     "sort, halves", "frame, halves"], rows, words=2))


TABLES = {"harmonics": harmonics}
