# SPDX-License-Identifier: Apache-2.0
"""What each format of scenes costs."""
from tables.markdown import count, significant, table
from tables.results import check_rows

NAME = "formats.json"
ERRORS = ("mean", "log_scale", "degrees", "opacity", "sh0", "sh_rest_rms")
TITLES = ["mean", "log-scale", "degrees", "opacity", "band 0", "higher bands"]


def read(source, machine):
    """The object in the file of formats_table."""
    path = source.path(machine, NAME)
    found = source.json(machine, NAME, "swiftgs-formats", single=list, read=list)
    check_rows(path, [found], texts=("scene", "size"), counts=("gaussians",))
    check_rows(path, found["single"], texts=("file_format",), counts=("bytes", "write_seconds", "read_seconds"),
               optional=("psnr_db",))
    check_rows(path, found["read"], texts=("file_format",), counts=("gaussians", "sh_degree", "bytes", "read_seconds"),
               optional=("psnr_db",))
    check_rows(path, [row.get("errors") for row in found["single"]], counts=ERRORS)
    return found


def decibels(value):
    return "same" if value is None else f"{value:.1f}"


def size_and_time(row, gaussians):
    """The cells of a file's size and of the time that it takes to read."""
    return [f"{row['bytes'] / 1e6:.1f}", f"{row['bytes'] / gaussians:.1f}", significant(row["read_seconds"])]


def formats(source, machine):
    """A scene through each format that is written: size, times and losses."""
    results = read(source, machine)
    rows = [[row["file_format"], *size_and_time(row, results["gaussians"]), significant(row["write_seconds"]),
             decibels(row["psnr_db"]), *(significant(row["errors"][key]) for key in ERRORS)]
            for row in results["single"]]
    return (f"{results['scene']}, {count(results['gaussians'])} Gaussians, its first view at {results['size']}: "
            "errors are the largest, those of higher bands root mean squares.\n\n" + table(
                ["written", "MB", "bytes a Gaussian", "read, s", "write, s", "dB"] + TITLES, rows))


def format_reads(source, machine):
    """Formats that are only read: files that other programs made of the scene."""
    rows = [[row["file_format"], str(row["sh_degree"]), *size_and_time(row, row["gaussians"]),
             significant(row["read_seconds"] / row["gaussians"] * 1e6), decibels(row["psnr_db"])]
            for row in read(source, machine)["read"]]
    return table(["read", "SH degree", "MB", "bytes a Gaussian", "read, s", "s a million Gaussians", "dB"], rows)


TABLES = {"formats": formats, "format-reads": format_reads}
