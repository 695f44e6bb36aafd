# SPDX-License-Identifier: Apache-2.0
"""Instructions of a (pixel, Gaussian) pair in the kernels: the paper's sections 3.2 and 5.3, and ours."""
from count_instructions import EXECUTED, STATIC, executed_rows, pairs_of, read_kernels, static_rows
from tables import paper
from tables.frames import Frames
from tables.markdown import table
from tables.results import InputError

STATIC_USED = ("kernel", "shared terms", "loads", "tests", "moves", "arithmetic", "kept", "skipped", "fewer",
               "whole loop", "pairs a pass")


def kernels_of(source, machine, scene):
    path = source.path(machine, f"instructions-{scene}.csv")
    kernels = source.once(lambda found: read_kernels([found]), path)
    if not kernels:
        raise InputError(f"{path}: no kernel of a rasterizer; expected what profile_kernels.sh leaves")
    return kernels


def instructions(source, machine, scene):
    """Counted from the machine code, beside the paper's."""
    kernels = kernels_of(source, machine, scene)
    columns = [STATIC.index(name) for name in STATIC_USED]
    rows = [[row[c] for c in columns] + [paper.INSTRUCTIONS.get(kind, "-")]
            for (kind, _), row in zip(kernels, static_rows(kernels))]
    return table([*STATIC_USED, "paper, arithmetic"], rows)


def executed(source, machine, scene):
    """What one frame of a scene's first view executed, in millions."""
    frames = Frames(source.results(machine, "matrix.json"))
    pairs = pairs_of((row for found in frames.of.values() for row in found), scene)
    rows = executed_rows(kernels_of(source, machine, scene), pairs)
    if not rows:
        path = source.path(machine, f"instructions-{scene}.csv")
        raise InputError(f"{path}: nothing was executed; expected a profile")
    return table(EXECUTED, rows)


TABLES = {"instructions": instructions, "executed": executed}
