# SPDX-License-Identifier: Apache-2.0
"""What single things cost: rows of one file each, shown as they are or over the first of their kind."""
from statistics import mean

from tables.frames import BEST, FRAME_STAGES, gaussians
from tables.markdown import count, decibel, ms, quotient, significant, table
from tables.blocks import backend, device, machine_name
from tables.results import InputError


def scene_and_count(row):
    return f"{row.scene}, {count(row.gaussians)}"


def found_in(rows, **members):
    """The rows that have all these members, at least one."""
    found = [row for row in rows if all(getattr(row, name) == value for name, value in members.items())]
    if not found:
        raise InputError(f"expected a row with {', '.join(f'{name} {value!r}' for name, value in members.items())}")
    return found


def median_of(rows, stage, **members):
    """Milliseconds of the one row that has these members; None where there is none."""
    return next((row.median(stage) for row in rows
                 if all(getattr(row, name) == value for name, value in members.items())), None)


def planes(source, machine):
    """Frames with each set of planes over those of colour alone."""
    about, rows = source.rows(machine, "planes.json")
    scenes = list(dict.fromkeys(row.scene for row in rows))
    colour = {scene: median_of(rows, "total", scene=scene, planes="") for scene in scenes}
    lines = [["colour alone, ms", *(ms(colour[scene]) for scene in scenes)]]
    for words in dict.fromkeys(row.planes for row in rows if row.planes):
        lines.append([", ".join(f"`{name}`" for name in words.split(",")),
                      *(quotient(median_of(rows, "total", scene=scene, planes=words), colour[scene]) for scene in scenes)])
    return (f"{device(about, backend(machine))}, `{rows[0].renderer}`, first views; frames over those of colour alone:\n\n"
            + table(["planes beside colour", *scenes], lines))


def placed(source, machine):
    """Frames of placed scenes over those of one scene, which come first."""
    (about, rows), first, lines = source.rows(machine, "placed.json"), {}, []
    for row in rows:
        time = row.median("wall")
        base = first.setdefault(row.scene, time)
        views = f", {row.batch:,} views" if row.batch > 1 else ""
        lines.append([f"{row.scene}{views}", row.placed, ms(time), quotient(time, base)])
    copies = ", with the copies of poses to the device" if backend(machine) == "cuda" else ""
    return (f"{device(about, backend(machine))}, `{rows[0].renderer}`; frames in a row{copies}:\n\n"
            + table(["scene", "frame", "ms", "over the first"], lines, words=2))


def lenses(source, machine):
    """Stages through each lens in each order, and the frame's time over the pinhole's in the same order."""
    results = source.results(machine, "lenses.json")
    capture, lines = results.rows[0].scene.rpartition("-")[0], []
    for order, words in {"": "as stored", "-ordered": "in space"}.items():
        pinhole = None
        for lens in ("pinhole", "opencv", "fisheye", "panorama"):  # as measure_matrix.sh calls them
            rows = found_in(results.rows, scene=f"{capture}-{lens}{order}", name=BEST)
            times = [mean(row.median(stage) for row in rows) for stage in FRAME_STAGES]
            pinhole = pinhole or times[-1]
            lines.append([lens, words, count(mean(row.visible for row in rows)), *map(ms, times),
                          quotient(times[-1], pinhole)])
    return (f"{machine_name(results)}, `{BEST}`, {capture}, {gaussians(rows[0].gaussians)}, milliseconds, means over "
            f"{len(rows)} views:\n\n"
            + table(["lens", "order", "visible splats", *FRAME_STAGES, "of the pinhole's"], lines, words=2))


def harmonics(source, machine):
    """Sort and frame of each scene with floats, and with other forms over these."""
    floats, *others = [source.results(machine, f"harmonics-{kept}.json") for kept in ("float", "smallest", "half")]
    lines = []
    for row in found_in(floats.rows, name=BEST):
        each = [found_in(file.rows, scene=row.scene, name=BEST)[0] for file in others]
        lines.append([f"{row.scene}, {gaussians(row.gaussians)}", each[0].harmonics or "floats",
                      *(ms(row.median(stage)) for stage in ("sort", "total")),
                      *(quotient(other.median(stage), row.median(stage)) for other in each
                        for stage in ("sort", "total"))])
    return (f"{machine_name(floats)}, `{BEST}`, first views: milliseconds with floats, and times over these:\n\n"
            + table(["scene", "smallest form", "sort, floats", "frame, floats", "sort, smallest", "frame, smallest",
                     "sort, halves", "frame, halves"], lines, words=2))


def size_and_time(row):
    """The cells of a file's size and of the time that it takes to read."""
    return [f"{row.file_bytes / 1e6:.1f}", f"{row.file_bytes / row.gaussians:.1f}", significant(row.read_seconds)]


def same_or_decibel(value):
    return "same" if value is None else f"{value:.1f}"


def formats(source, machine):
    """A scene through each format that is written: size, times and losses."""
    rows = [row for row in source.rows(machine, "formats.json")[1] if row.write_seconds is not None]
    lost = {"mean": "mean", "log_scale": "log-scale", "degrees": "degrees", "opacity": "opacity", "sh0": "band 0",
            "sh_rest_rms": "higher bands"}
    lines = [[row.file_format, *size_and_time(row), significant(row.write_seconds), same_or_decibel(row.psnr_db),
              *(significant(row.errors[key]) for key in lost)] for row in rows]
    first = rows[0]
    return (f"{first.scene}, {count(first.gaussians)} Gaussians, its first view at {first.width}x{first.height}: "
            "errors are the largest, those of higher bands root mean squares.\n\n" + table(
                ["written", "MB", "bytes a Gaussian", "read, s", "write, s", "dB", *lost.values()], lines))


def format_reads(source, machine):
    """Formats that are only read: files that other programs made of the scene."""
    rows = [row for row in source.rows(machine, "formats.json")[1] if row.sh_degree is not None]
    lines = [[row.file_format, str(row.sh_degree), *size_and_time(row),
              significant(row.read_seconds / row.gaussians * 1e6), same_or_decibel(row.psnr_db)] for row in rows]
    return table(["read", "SH degree", "MB", "bytes a Gaussian", "read, s", "s a million Gaussians", "dB"], lines)


def rate(row, of):
    """Frames a second."""
    return significant(1e3 / getattr(row.ms["wall"], of)) if row else "-"


def python(source, *machines):
    """Frames a second in both languages, and what Python adds to each."""
    lines = []
    for machine in machines:
        about, rows = source.rows(machine, "python.json")
        for cpp in found_in(rows, call="C++"):
            calls = {row.call: row for row in found_in(rows, scene=cpp.scene, renderer=cpp.renderer)}
            for of in ("median", "p10"):
                lines.append([device(about, cpp.renderer.partition("/")[0]), scene_and_count(cpp), of,
                              *(rate(calls.get(call), of) for call in ("C++", "out", "new", "arrays")),
                              f"{calls['out'].outside_us[of] - cpp.outside_us[of]:.0f}"])
    return table(["device", "scene, Gaussians", "of frames", "C++, 1/s", "`out`, 1/s", "`new`, 1/s", "`arrays`, 1/s",
                  "Python adds, us"], lines, words=3)


CALLS = ("swiftgs", "swiftgs, matrices on the host", "gsplat", "gsplat, not packed", "swiftgs, scene kept")


def beside_gsplat(source, machine, *scenes):
    """Times of a call, and decibels between both; of these scenes."""
    rows, lines = source.rows(machine, "beside-gsplat.json")[1], []
    for scene in scenes:
        for first in found_in(rows, scene=scene, renderer=CALLS[0]):
            of_frame = {"scene": scene, "camera_model": first.camera_model, "batch": first.batch}
            lines.append([scene_and_count(first), first.camera_model, str(first.batch),
                          *(ms(median_of(rows, "wall", renderer=call, **of_frame)) for call in CALLS),
                          decibel(first.between_db)])
    return table(["scene, Gaussians", "`camera_model`", "views of a frame", *(f"{call}, ms" for call in CALLS),
                  "between both, dB"], lines, words=2)


def beside_gsplat_of_worlds(source, machine):
    """Times of a call that draws a batch of scenes, and images a second of each library's fastest call."""
    rows = found_in(source.rows(machine, "beside-gsplat.json")[1], scene="worlds")
    first, times = rows[0], {row.renderer: row.median("wall") for row in rows}
    fastest = (min(time for call, time in times.items() if call.startswith(name)) for name in ("swiftgs", "gsplat"))
    return table(["worlds, Gaussians of each", "views of each", *(f"{call}, ms" for call in times),
                  "swiftgs, images/s", "gsplat, images/s", "between both, dB"],
                 [[f"{count(first.worlds)} of {count(first.gaussians)}",
                   f"{count(first.batch)} of {first.width}x{first.height}", *map(ms, times.values()),
                   *(count(first.worlds * first.batch / time * 1e3) for time in fastest), decibel(first.between_db)]],
                 words=2)


# What the page shows of the searches' stages.
STAGES_SHOWN = ("mean", "depth", "determinant without blur", "`l0`", "`l1`", "cutoff", "colour of degree 3", "`Exp2`",
                "alpha `axis-shared-threshold-float-cholesky`", "transmittance after 10000 unequal layers")


def ulps(source, machine):
    """The largest errors that `ulps_table` found by search, each on the target that errs most."""
    about, rows = source.rows(machine, "ulps.json")
    lines = []
    for name in STAGES_SHOWN:
        of_stage = found_in(rows, stage=name)
        for yardstick in dict.fromkeys(row.yardstick for row in of_stage):
            worst = max(found_in(of_stage, yardstick=yardstick), key=lambda row: row.ulps)
            lines.append([name, yardstick, worst.target, f"{worst.ulps:.2f}"])
    return f"{device(about, 'cpu')}:\n\n" + table(["stage", "measured in", "worst on", "error"], lines, words=3)


def ranks(source, machine):
    """Frames over ranks: the quickest run of each carrier on each number of ranks."""
    rows = [row for row in source.rows(machine, "ranks.json")[1] if row.checksum]
    columns = list(dict.fromkeys((row.carrier, row.ranks) for row in sorted(rows, key=lambda row: row.ranks)))
    lines = []
    for scene, width, height in dict.fromkeys((row.scene, row.width, row.height) for row in rows):
        times = [min((row.median("wall") for row in rows if (row.scene, row.width, row.carrier, row.ranks)
                      == (scene, width, carrier, number)), default=None) for carrier, number in columns]
        lines.append([f"{scene}, {width}x{height}", *map(ms, times)])
    return table(["scene, image", *(f"{number}, {carrier}" if carrier else str(number) for carrier, number in columns)],
                 lines)


TABLES = {"planes": planes, "placed": placed, "lenses": lenses, "harmonics": harmonics, "formats": formats,
          "format-reads": format_reads, "python": python, "beside-gsplat": beside_gsplat,
          "beside-gsplat-worlds": beside_gsplat_of_worlds, "ulps": ulps, "ranks": ranks}
