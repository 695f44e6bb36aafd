# SPDX-License-Identifier: Apache-2.0
"""Hard frames: how far the exponent representations are from float64, from the files of `swiftgs stress`."""
import math

from tables.markdown import prose, significant, table
from tables.results import InputError, check_rows
from tables.source import backend, device

# The columns, and the rasterizers whose worse value each shows.
FORMS = {"per-pixel": ("per-pixel",),
         **{form: (f"axis-shared-{form}", f"axis-shared-threshold-{form}")
            for form in ("float-split", "float-cholesky", "half-split")}}
GATE = 10
TEXTS = ("family", "severity_label", "renderer", "backend", "raster")
COUNTS = ("width", "height", "seeds", "failed")
FILES = {"": "stress.json", "large": "stress-large.json"}


def read_stress(source, machine, name):
    """The object in a file of `swiftgs stress`, checked."""
    found, path = source.json(machine, name, "swiftgs-stress", machine=dict, rows=list), source.path(machine, name)
    if not found["rows"]:
        raise InputError(f"{path}: rows: expected an array that is not empty")
    check_rows(path, found["rows"], texts=TEXTS, counts=COUNTS,
               optional=("strict_normalised_error", "max_abs", "ambiguity"))
    return found


def worst(rows, member):
    """The largest; what is not finite is null in the file."""
    return max(math.inf if row.get(member) is None else row[member] for row in rows)


def number(value):
    return "inf" if math.isinf(value) else f"{value:.1e}" if value >= 1e4 else significant(value, 2)


def cell(rows):
    """Worst strict normalised error, emphasised above the gate, and largest error in parentheses."""
    if not rows:
        return "-"
    if any(row["failed"] for row in rows):
        return "**failed**"
    error = worst(rows, "strict_normalised_error")
    text = "0" if error == 0 else f"{error:.2f}" if error < GATE else number(error)
    open_pixels = "†" if worst(rows, "ambiguity") >= 1 else ""
    return f"{'**' + text + '**' if error > GATE else text}{open_pixels} ({number(worst(rows, 'max_abs'))})"


def stability(source, machine, *words):
    """The worst strict normalised error and the largest error of each family. The words: 'large', for large
    images, and families, if not all."""
    size = "large" if "large" in words else ""
    families = [word for word in words if word != "large"]
    found, name = read_stress(source, machine, FILES[size]), backend(machine)
    rows = [row for row in found["rows"] if row["backend"] == name]
    if not rows:
        raise InputError(f"{source.path(machine, FILES[size])}: no rows of the backend '{name}'")
    known = list(dict.fromkeys(row["family"] for row in rows))
    for family in families:
        if family not in known:
            raise InputError(f"{source.path(machine, FILES[size])}: no family '{family}'; expected 'large' or one of "
                             f"{', '.join(known)}")
    rows = [row for row in rows if row["family"] in (families or known)]
    sizes = list(dict.fromkeys((row["width"], row["height"]) for row in rows))
    lines = []
    for width, height in sizes:
        here = [row for row in rows if (row["width"], row["height"]) == (width, height)]
        for family in dict.fromkeys(row["family"] for row in here):
            of_family = [row for row in here if row["family"] == family]
            lines.append([f"`{family}`" + (f", {width}x{height}" if len(sizes) > 1 else "")] + [
                cell([row for row in of_family if row["raster"] in rasters]) for rasters in FORMS.values()])
    images = " and ".join(f"{width}x{height}" for width, height in sizes)
    return prose(f"{device(found['machine'], name)}, `{name}`, images of {images}, {rows[0]['seeds']} seeds at "
                 f"each severity: the worst strict normalised error, and in parentheses the largest absolute error of a "
                 f"colour. †: of some "
                 f"pixels everything is open, and these are not judged.") \
        + "\n\n" + table(["family", *FORMS], lines)


def severities(source, machine, family):
    """The largest error of a colour at each severity of one family."""
    found, name = read_stress(source, machine, FILES[""]), backend(machine)
    rows = [row for row in found["rows"] if (row["backend"], row["family"]) == (name, family)]
    if not rows:
        raise InputError(f"{source.path(machine, FILES[''])}: no rows of '{name}' and the family '{family}'")
    values = sorted({row["severity"] for row in rows})
    lines = [[f"`{column}`"] + [number(worst([row for row in rows if row["raster"] in rasters
                                              and row["severity"] == value], "max_abs")) for value in values]
             for column, rasters in FORMS.items()]
    return prose(f"{device(found['machine'], name)}, `{name}`, `{family}`, {rows[0]['seeds']} seeds: the largest "
                 f"absolute error of a colour.") \
        + "\n\n" + table([rows[0]["severity_label"], *(f"{value:g}" for value in values)], lines)


TABLES = {"stability": stability, "stability-severities": severities}
