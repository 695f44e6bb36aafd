# SPDX-License-Identifier: Apache-2.0
"""What each policy costs on a machine, in the README and beside the results; machines and commands."""
from statistics import median

from tables.frames import (BASELINE, BOX, CHOLESKY, ELLIPSE, RASTERS, SHARED, SQUARE, THRESHOLD, VANILLA, Frames,
                           gaussians, label)
from tables.markdown import decibel, prose, table
from tables.results import InputError, read_json
from tables.source import backend, machine_name

SHOWN = tuple(f"early/{raster}/{ELLIPSE}" for raster in RASTERS) + (
    f"early/{CHOLESKY}/{BOX}", f"early/{CHOLESKY}/{SQUARE}", f"standard/{CHOLESKY}/{ELLIPSE}", VANILLA)
# Ten of them for the README, with whose choices they are.
HEADLINE = {VANILLA: "INRIA's", BASELINE: "gsplat's choices, our code",
            f"early/{THRESHOLD}half-split/{BOX}": "the paper's", f"early/per-pixel/{ELLIPSE}": "",
            f"early/{THRESHOLD}float-split/{ELLIPSE}": "", f"early/{CHOLESKY}/{SQUARE}": "", f"early/{CHOLESKY}/{BOX}": "",
            f"standard/{CHOLESKY}/{ELLIPSE}": "", f"early/{SHARED}float-cholesky/{ELLIPSE}": "",
            f"early/{CHOLESKY}/{ELLIPSE}": "**ours**"}
NAMING = ("matrix.json", "scaling-gaussians.json", "scaling-pixels.json", "pruned.json")  # any names its machine
PLACE = ("scene", "gaussians", "enlarge", "view", "scale", "conventions")


def captures(frames):
    """The scenes that are no built-in one, or all where there is no other."""
    return [scene for scene in frames.scenes if scene.name != "builtin"] or frames.scenes


def milliseconds(frames, scene, name):
    """A frame's, the median over the views."""
    time = median(row.ms["total"].median for row in frames.rows(scene, name))
    return f"{time:.{2 if time < 10 else 1}f}"


def cell(frames, scene, name):
    return f"{milliseconds(frames, scene, name)} ms, {decibel(frames.worst_psnr(scene, name))} dB"


def views_of(frames, scenes):
    """How many views the times are medians of, in words."""
    numbers = sorted({len(frames.rows(scene, SHOWN[0])) for scene in scenes})
    if numbers == [1]:
        return "one view"
    return f"{numbers[0]} views" if len(numbers) == 1 else f"{numbers[0]} to {numbers[-1]} views"


def summary(source, machine):
    """What a machine needs for a frame with each policy, and how exact that is, with the sentences around it."""
    results = source.results(machine, "matrix.json")
    frames = Frames(results)
    scenes = captures(frames)
    rows = [[f"`{backend(machine)}/{name}`", *(cell(frames, scene, name) for scene in scenes)] for name in SHOWN]
    return (prose(f"{machine_name(results)}: milliseconds a frame, the median over {views_of(frames, scenes)} of each "
                  f"capture, and PSNR against float64 in the worst view compared.") + "\n\n"
            + table(["renderer", *(f"{label(scene)}, {frames.sizes[scene]}" for scene in scenes)], rows)
            + "\n\n" + errors(results, frames))


def headline(source, *machines):
    """Ten renderers on the captures of every machine, and the least PSNR over these."""
    if not machines:
        raise InputError("table 'headline': expected a MACHINE or several")
    found = [Frames(source.results(machine, "matrix.json")) for machine in machines]
    scenes = captures(found[0])
    header, rows = ["sort/raster/bounds", "choices"], [[f"`{name}`", whose] for name, whose in HEADLINE.items()]
    places = []
    for machine, frames in zip(machines, found):
        if captures(frames) != scenes:
            raise InputError(f"{frames.results.path}: expected the captures of {found[0].results.path}")
        first, *others = [scene.name for scene in scenes]
        header += [f"`{backend(machine)}`, ms: {first}", *others, "dB"]
        for row, name in zip(rows, HEADLINE):
            psnr = [frames.worst_psnr(scene, name) for scene in scenes]
            row += [*(milliseconds(frames, scene, name) for scene in scenes),
                    decibel(min((value for value in psnr if value is not None), default=None))]
        places.append(f"`{backend(machine)}` is {machine_name(frames.results)}, {views_of(frames, scenes)} a capture")
    sizes = ", ".join(f"{scene.name} ({gaussians(scene.gaussians)} Gaussians, {found[0].sizes[scene]})"
                      for scene in scenes)
    return (prose(f"Milliseconds a frame, the median over views of {sizes}. dB is PSNR against float64 in the worst view "
                  f"compared. {'; '.join(places)}.")
            + "\n\n" + table(header, rows, words=2))


def errors(results, frames):
    """What the float policies with conservative bounds lose, in two sentences."""
    exact = [row for rows in frames.of.values() for row in rows if row.bounds != SQUARE and "half" not in row.raster]
    judged = [row.max_abs for row in exact if row.max_abs is not None]
    if not judged:
        raise InputError(f"{results.path}: no errors; expected some, of --errors 1")
    photo = {tuple(view.get(name) for name in PLACE): view.get("photo_psnr_db") for view in results.views}
    seen = [row for row in exact if row.photo_psnr_db is not None and photo.get(row.place) is not None]
    apart = [abs(row.photo_psnr_db - photo[row.place]) for row in seen]
    text = f"The float policies with conservative bounds differ from the reference by {max(judged):.4f} at most."
    if apart:
        *others, last = dict.fromkeys(row.scene for row in seen)
        scenes = f"{', '.join(others)} and {last}" if others else last
        text += (f" Against the photographs of {scenes} that training did not see, each is within "
                 f"{max(*apart, 1e-4):.4f} dB of what the reference has.")
    return prose(text)


def machine_words(source, machine):
    """A machine, and what ran there when."""
    name = next((name for name in NAMING if source.has(machine, name)), NAMING[0])
    found = source.results(machine, name).machine
    # The toolkit's version, which the architectures and the flags follow.
    toolkit = str(found.get("cuda")).split(" for ")[0]
    device = f"{found['gpu']}, driver {found.get('driver')}, CUDA {toolkit}, in a host with " \
        if found.get("gpu") and machine == "gpu" else ""
    return (f"{device}{found.get('cores')} cores of {found.get('cpu')}, {found.get('memory_gib')} GiB, "
            f"{found.get('system')}; {found.get('compiler')}, `{found.get('flags')}`; {found.get('date')}")


def commit_of(found):
    commit = str(found.get("commit", "unknown"))
    return f"`{commit[:12]}`{' with changes' if commit.endswith('+') else ''}"


def files(source, machine):
    """The machine, and the commands that made the files in its folder, of those that tell it."""
    rows = []
    for name in source.names(machine, "", ".json"):
        found = read_json(source.path(machine, name))  # as it is, where a file of another format may be
        if isinstance(found.get("machine"), dict) and found.get("command"):
            rows.append([f"`{name}`", commit_of(found["machine"]), f"`{found['command']}`"])
    return prose(machine_words(source, machine) + ".") + "\n\n" + table(["file", "commit", "command"], rows, words=3)


TABLES = {"summary": summary, "headline": headline, "files": files}
