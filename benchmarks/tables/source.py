# SPDX-License-Identifier: Apache-2.0
"""Where the tables' numbers come from: a folder of results for each kind of machine, and its files."""
import os
import re

from tables.results import InputError, read, read_format

RESULTS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "results")
MACHINES = ("gpu", "many-cores", "two-cores")  # folders; each holds the newest file of a kind, and need not hold all


class Source:
    """The results of the machines, each file read once."""

    def __init__(self, results=RESULTS):
        self.root, self.found = results, {}

    def path(self, machine, name):
        """Of a file in a machine's folder; InputError where it is not there."""
        if machine not in MACHINES and not os.path.isdir(os.path.join(self.root, machine)):
            raise InputError(f"no machine '{machine}'; expected one of {', '.join(MACHINES)}, or a folder in {self.root}")
        path = os.path.join(self.root, machine, name)
        if not os.path.isfile(path):
            raise InputError(f"{path}: no such file; expected what benchmarks/measure_matrix.sh leaves")
        return path

    def has(self, machine, name):
        """Whether a file is in a machine's folder."""
        return os.path.isfile(os.path.join(self.root, machine, name))

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
        folder = os.path.join(self.root, machine)
        names = sorted(n for n in os.listdir(folder) if n.startswith(start) and n.endswith(end)) \
            if os.path.isdir(folder) else []
        if not names:
            raise InputError(f"{folder}: no {start}*{end}; expected what benchmarks/measure_matrix.sh leaves")
        return names


def family(name):
    """The first word of a file's name: files that are measured together."""
    return re.split("[-.]", os.path.basename(name))[0]


def backend(machine):
    """The backend that a machine's results are of; a folder of one's own may have its name."""
    return "cuda" if machine == "gpu" else machine if machine in ("cuda", "serial") else "cpu"


def processor(machine):
    """The host in words, from the member `machine` of a file."""
    return f"{machine.get('cpu', 'unknown')}, {machine.get('cores', '?')} cores"


def device(machine, name):
    """What ran a backend, in words, as 'NVIDIA H200'. A host's files name its GPU too."""
    return str(name == "cuda" and machine.get("gpu") or processor(machine))


def machine_name(results):
    """The device that rendered, in words."""
    return device(results.machine, "cuda" if any(row.backend == "cuda" for row in results.rows) else "cpu")
