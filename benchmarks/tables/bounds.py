# SPDX-License-Identifier: Apache-2.0
"""What tighter bounds save: intersections, and the time of each stage."""
from tables.frames import CHOLESKY, FRAME_STAGES, Frames, gaussians
from tables.markdown import count, decibel, ms, prose, table
from tables.source import machine_name


def bounds(source, machine):
    """One renderer within each kind of bounds on each scene, means over its views."""
    results = source.results(machine, "matrix.json")
    frames = Frames(results)
    rows = []
    for scene in frames.scenes:
        for kind in frames.bounds(scene, f"early/{CHOLESKY}"):
            name = f"early/{CHOLESKY}/{kind}"
            rows.append([f"{scene.name}, {gaussians(scene.gaussians)}", kind,
                         count(frames.mean_of(scene, name, "intersections")),
                         *(ms(frames.mean(scene, name, stage)) for stage in FRAME_STAGES),
                         decibel(frames.worst_psnr(scene, name))])
    return (prose(f"{machine_name(results)}, `early/{CHOLESKY}`: milliseconds a frame and intersections, means over views; "
                  f"PSNR against float64 in the worst view compared.") + "\n\n"
            + table(["scene", "bounds", "intersections", *FRAME_STAGES, "dB"], rows, words=2))


TABLES = {"bounds": bounds}
