# SPDX-License-Identifier: Apache-2.0
"""What each format of scenes costs."""
from tables.markdown import count, significant, table

NAME = "formats.json"


def read(source, machine):
    return source.json(machine, NAME, "swiftgs-formats", single=list, pairs=list)


def decibels(value):
    return "same" if value is None else f"{value:.1f}"


def formats(source, machine):
    """A scene through each format that is written: size, times and losses."""
    results = read(source, machine)
    rows = []
    for row in results["single"]:
        errors = row["errors"]
        rows.append([row["file_format"], f"{row['bytes'] / 1e6:.1f}",
                     f"{row['bytes'] / results['gaussians']:.1f}", significant(row["write_seconds"]),
                     significant(row["read_seconds"]), decibels(row["psnr_db"])]
                    + [significant(errors[key]) for key in
                       ("mean", "log_scale", "degrees", "opacity", "sh0", "sh_rest_rms")])
    return (f"{results['scene']}, {count(results['gaussians'])} Gaussians, its first view at {results['size']}: "
            "errors are the largest, those of higher bands root mean squares.\n\n" + table(
                ["written", "MB", "bytes a Gaussian", "write, s", "read, s", "dB", "mean", "log-scale", "degrees",
                 "opacity", "band 0", "higher bands"], rows))


def format_pairs(source, machine):
    """Decibels of a scene that was written in one format and then in another."""
    results = read(source, machine)
    names = list(dict.fromkeys(row["first"] for row in results["pairs"]))
    found = {(row["first"], row["second"]): row["psnr_db"] for row in results["pairs"]}
    rows = [[first] + [decibels(found[first, second]) for second in names] for first in names]
    return table(["first"] + [f"then {name}" for name in names], rows)


TABLES = {"formats": formats, "format-pairs": format_pairs}
