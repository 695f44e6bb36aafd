# SPDX-License-Identifier: Apache-2.0
"""Where the tables' numbers come from: which folder of results stands for which machine, and its files."""
import os

from tables.results import InputError, read, read_format

RESULTS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "results")
# The folders that README.md and docs/ show: a GPU, a processor with many cores and two with few, which need not have
# all files. Whoever measures anew changes them here.
FOLDERS = {"gpu": "2026-11-21-nvidia-h200", "cpu": "2026-11-21-intel-xeon-16-cores",
           "cpu2": "2026-11-21-intel-xeon-2-cores", "amd": "2026-11-22-amd-epyc-2-cores",
           "h200": "2026-11-22-nvidia-h200", "xeon": "2026-11-23-intel-xeon-2-cores",
           "hopper": "2026-11-23-nvidia-h200", "nvidia24": "2026-11-24-nvidia-h200",
           "xeon24": "2026-11-24-intel-xeon-2-cores", "nvidia": "2026-11-25-nvidia-h200",
           "h100": "2026-11-26-nvidia-h100", "xeon26": "2026-11-26-intel-xeon-16-cores"}


class Source:
    """The results of the machines, each file read once."""

    def __init__(self, results=RESULTS, folders=None):
        self.root, self.folders, self.found = results, folders or FOLDERS, {}

    def path(self, machine, name):
        """Of a file in a machine's folder; InputError where it is not there."""
        if machine not in self.folders:
            raise InputError(f"no machine '{machine}'; expected one of {', '.join(self.folders)}")
        path = os.path.join(self.root, self.folders[machine], name)
        if not os.path.isfile(path):
            raise InputError(f"{path}: no such file; expected what benchmarks/measure_matrix.sh leaves")
        return path

    def has(self, machine, name):
        """Whether a file is in a machine's folder."""
        return os.path.isfile(os.path.join(self.root, self.folders.get(machine, machine), name))

    def results(self, machine, name):
        """The Results of a file of `swiftgs bench`."""
        return self.once(read, self.path(machine, name))

    def json(self, machine, name, form, /, **members):
        """The object in a file of another command, as read_format gives it."""
        return self.once(lambda path: read_format(path, form, **members), self.path(machine, name))

    def once(self, reader, path):
        if path not in self.found:
            self.found[path] = reader(path)
        return self.found[path]

    def names(self, machine, start, end):
        """Of the files in a machine's folder that begin and end so, sorted; at least one."""
        folder = os.path.join(self.root, self.folders.get(machine, machine))
        names = sorted(n for n in os.listdir(folder) if n.startswith(start) and n.endswith(end)) \
            if os.path.isdir(folder) else []
        if not names:
            raise InputError(f"{folder}: no {start}*{end}; expected what benchmarks/measure_matrix.sh leaves")
        return names


def backend(machine):
    """The backend that a machine's results are of."""
    return "cuda" if machine in ("gpu", "h200", "nvidia", "h100") else "cpu"


def processor(machine):
    """The host in words, from the member `machine` of a file."""
    return f"{machine.get('cpu', 'unknown')}, {machine.get('cores', '?')} cores"


def machine_name(results):
    """The device that rendered, in words, as 'NVIDIA H200'. A host's files name its GPU too."""
    rendered_there = any(row.backend == "cuda" for row in results.rows)
    return str(rendered_there and results.machine.get("gpu") or processor(results.machine))
