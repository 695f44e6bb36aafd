# SPDX-License-Identifier: Apache-2.0
"""What each format of scenes costs."""
from tables.markdown import count, significant, table
from tables.results import check_rows

NAME = "formats.json"
ERRORS = ("mean", "log_scale", "degrees", "opacity", "sh0", "sh_rest_rms")


def read(source, machine):
    """The object in the file of formats_table."""
    path = source.path(machine, NAME)
    found = source.json(machine, NAME, "swiftgs-formats", single=list, pairs=list)
    check_rows(path, [found], texts=("scene", "size"), counts=("gaussians",))
    check_rows(path, found["single"], texts=("file_format",), counts=("bytes", "write_seconds", "read_seconds"),
               optional=("psnr_db",))
    check_rows(path, [row.get("errors") for row in found["single"]], counts=ERRORS)
    check_rows(path, found["pairs"], texts=("first", "second"), optional=("psnr_db",))
    return found


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
                    + [significant(errors[key]) for key in ERRORS])
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
