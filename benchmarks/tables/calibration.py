# SPDX-License-Identifier: Apache-2.0
"""What the calibrated choice of the sort is worth: its regret against the better strategy."""
from tables.frames import gaussians
from tables.markdown import ms, prose, table
from tables.results import InputError, check_rows

NUMBERS = ("gaussians", "width", "height", "views", "standard_ms", "early_ms", "adaptive_ms", "regret", "regret_error",
           "sort_regret", "sort_regret_error")

LIMIT = 0.03  # regret that a choice should not exceed
ERRORS = 2  # standard errors that a row may be beyond it, or has to be below it


def rows_of(source, machine):
    """Those of all files of `swiftgs calibrate --check` in a machine's folder."""
    found = []
    for name in source.names(machine, "calibration-", ".json"):
        if name.endswith(".sort.json"):  # the choice itself
            continue
        rows = source.json(machine, name, "swiftgs-calibration-check", rows=list)["rows"]
        check_rows(source.path(machine, name), rows, numbers=NUMBERS)
        found += rows
    if not found:
        raise InputError(f"{source.folders[machine]}: no row of a calibration's check; expected some")
    return found


def regret_cell(value, error):
    return f"{100 * value:+.1f} ± {100 * error:.1f} %"


def limit(found, what, member):
    """On how many rows a regret stays below LIMIT, in a sentence; rows that do not, by name."""
    def names(rows):
        return "; ".join(f"{row.get('scene')}, {row['width']}x{row['height']}, {row.get('bounds')}" for row in rows)

    error = f"{member}_error"
    above = [row for row in found if row[member] - ERRORS * row[error] > LIMIT]
    near = [row for row in found if row not in above and row[member] + ERRORS * row[error] > LIMIT]
    held = len(found) - len(above) - len(near)
    text = f"For {what} the limit of {100 * LIMIT:.0f} % holds on " \
        f"{'all' if held == len(found) else f'{held} of'} {len(found)} rows, with two standard errors added"
    if near:
        text += f"; {len(near)} {'is' if len(near) == 1 else 'are'} within two standard errors of it ({names(near)})"
    if above:
        text += f"; {len(above)} {'is' if len(above) == 1 else 'are'} above it by more ({names(above)})"
    return text + "."


def regret(source, machine):
    """The choice, and what it loses, for each scene, size of the image and bounds."""
    found = rows_of(source, machine)
    rows = [[f"{row.get('scene')}, {gaussians(row['gaussians'])}", f"{row['width']}x{row['height']}",
             str(row.get("bounds")), str(row.get("choice")), *(ms(row[f"{sort}_ms"]) for sort in
                                                               ("standard", "early", "adaptive")),
             regret_cell(row["regret"], row["regret_error"]), regret_cell(row["sort_regret"], row["sort_regret_error"])]
            for row in found]
    worst = max(found, key=lambda row: row["regret"])
    text = prose(f"The largest regret of a frame is {regret_cell(worst['regret'], worst['regret_error'])}, of "
                 f"{len(found)} choices. {limit(found, 'the frame', 'regret')} "
                 f"{limit(found, 'the sort alone', 'sort_regret')}")
    return f"{found[0].get('device')}, milliseconds a frame:\n\n" + table(
        ["scene", "image", "bounds", "choice", "standard", "early", "adaptive", "regret", "of the sort alone"], rows,
        words=4) + "\n\n" + text


TABLES = {"regret": regret}
