# SPDX-License-Identifier: Apache-2.0
"""Hard frames: how far the exponent representations are from float64, from the files of `swiftgs stress`."""
import math

from tables.markdown import prose, significant, table
from tables.blocks import backend, device
from tables.results import InputError

# The columns, and the rasterizers whose worse value each shows.
FORMS = {"per-pixel": ("per-pixel",),
         **{form: (f"axis-shared-{form}", f"axis-shared-threshold-{form}")
            for form in ("float-split", "float-cholesky", "half-split")}}
GATE = 10
FILES = {"": "stress.json", "large": "stress-large.json"}


def read_stress(source, machine, name):
    """(the device in words, rows of its backend) of a file of `swiftgs stress`."""
    about, rows = source.rows(machine, name, "swiftgs-stress")
    found = [row for row in rows if row.backend == backend(machine)]
    if not found:
        raise InputError(f"{source.path(machine, name)}: no rows of the backend '{backend(machine)}'")
    return f"{device(about, backend(machine))}, `{backend(machine)}`", found


def in_families(rows, families):
    """Those of the families, if there are any."""
    known = list(dict.fromkeys(row.family for row in rows))
    for family in families:
        if family not in known:
            raise InputError(f"no family '{family}'; expected one of {', '.join(known)}")
    return [row for row in rows if row.family in (families or known)]


def worst(rows, member):
    """The largest; what is not finite is null in the file."""
    return max(math.inf if getattr(row, member) is None else getattr(row, member) for row in rows)


def number(value):
    return "inf" if math.isinf(value) else f"{value:.1e}" if value >= 1e4 else significant(value, 2)


def cell(rows):
    """Worst strict normalised error, emphasised above the gate, and largest error in parentheses."""
    if not rows:
        return "-"
    if any(row.failed for row in rows):
        return "**failed**"
    error = worst(rows, "strict_normalised_error")
    text = "0" if error == 0 else f"{error:.2f}" if error < GATE else number(error)
    open_pixels = "†" if worst(rows, "ambiguity") >= 1 else ""
    return f"{'**' + text + '**' if error > GATE else text}{open_pixels} ({number(worst(rows, 'max_abs'))})"


def stability(source, machine, *words):
    """The worst strict normalised error and the largest error of each family. The words: 'large', for large
    images, and families, if not all."""
    where, found = read_stress(source, machine, FILES["large" if "large" in words else ""])
    rows = in_families(found, [word for word in words if word != "large"])
    sizes, lines = list(dict.fromkeys((row.width, row.height) for row in rows)), []
    for width, height in sizes:
        here = [row for row in rows if (row.width, row.height) == (width, height)]
        for family in dict.fromkeys(row.family for row in here):
            lines.append([f"`{family}`" + (f", {width}x{height}" if len(sizes) > 1 else "")] + [
                cell([row for row in here if row.family == family and row.raster in rasters])
                for rasters in FORMS.values()])
    images = " and ".join(f"{width}x{height}" for width, height in sizes)
    return prose(f"{where}, images of {images}, {rows[0].seeds} seeds at each severity: the worst strict normalised "
                 f"error, and in parentheses the largest absolute error of a colour. †: of some pixels everything is "
                 f"open, and these are not judged.") \
        + "\n\n" + table(["family", *FORMS], lines)


def severities(source, machine, family):
    """The largest error of a colour at each severity of one family."""
    where, found = read_stress(source, machine, FILES[""])
    rows = in_families(found, [family])
    values = sorted({row.severity for row in rows})
    lines = [[f"`{column}`"] + [number(worst([row for row in rows if row.raster in rasters and row.severity == value],
                                             "max_abs")) for value in values] for column, rasters in FORMS.items()]
    return prose(f"{where}, `{family}`, {rows[0].seeds} seeds: the largest absolute error of a colour.") \
        + "\n\n" + table([rows[0].severity_label, *(f"{value:g}" for value in values)], lines)


TABLES = {"stability": stability, "stability-severities": severities}
