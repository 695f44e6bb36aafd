# SPDX-License-Identifier: Apache-2.0
"""What each kernel of a frame costs, as a profiler measured it."""
import csv
import re
from statistics import mean

from tables.markdown import table
from tables.results import InputError

# (column, metric of ncu, divided by what, digits)
METRICS = (("us each", "gpu__time_duration.sum", 1e3, 1),
           ("million warp instructions", "smsp__inst_executed.sum", 1e6, 2),
           ("MB of memory traffic", "dram__bytes.sum", 1e6, 1),
           ("registers", "launch__registers_per_thread", 1, 0),
           ("warps active, %", "sm__warps_active.avg.pct_of_peak_sustained_active", 1, 0),
           ("issue slots, %", "smsp__issue_active.avg.pct_of_peak_sustained_active", 1, 0))


def short(kernel):
    """A kernel's name without namespaces and arguments, and with CUB's policies left out."""
    name = re.sub(r"\(.*\)$", "", kernel.replace("(bool)", ""))
    name = re.sub(r"^void |swiftgs::|kernels::|cub::|<unnamed>::", "", name)
    return re.sub(r"^(DeviceRadixSort\w+|DeviceScan\w+).*", r"\1", name)


def read_metrics(path):
    """{name: [{metric: value} of each launch]}, in the order of first launches."""
    launches = {}
    try:
        with open(path, encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                launch = launches.setdefault(row["ID"], {"name": short(row["Kernel Name"])})
                launch[row["Metric Name"]] = float(row["Metric Value"].replace(",", ""))
    except (KeyError, ValueError, AttributeError) as error:
        raise InputError(f"{path}: {error}; expected kernels and metrics as ncu prints them") from None
    found = {}
    for launch in launches.values():
        found.setdefault(launch["name"], []).append(launch)
    return found


def kernels(source, machine, scene):
    """Means over the launches of each kernel in the first view of a scene."""
    path = source.path(machine, f"kernels-{scene}.csv")
    found = source.once(read_metrics, path)
    rows = []
    for name, launches in found.items():
        cells = []
        for _, metric, unit, digits in METRICS:
            if any(metric not in launch for launch in launches):
                raise InputError(f"{path}: {name}: no {metric}; expected what profile_kernels.sh leaves")
            cells.append(f"{mean(launch[metric] for launch in launches) / unit:.{digits}f}")
        rows.append([f"`{name}`", str(len(launches)), *cells])
    return table(["kernel", "launches", *(column for column, *_ in METRICS)], rows)


TABLES = {"kernels": kernels}
