# SPDX-License-Identifier: Apache-2.0
"""What the result files of a machine were measured on."""
import json
import os
import re

from tables.markdown import table
from tables.blocks import backend, commit_of, device
from tables.results import InputError


def files(source, machine):
    """The newest first; files that are measured together have the same first word and one cell."""
    folder, runs = os.path.join(source.root, machine), {}
    for name in sorted(name for name in os.listdir(folder) if name.endswith(".json")):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            about = json.load(file)["machine"]
        run = device(about, backend(machine)), about["date"], commit_of(about)
        runs.setdefault(run, {}).setdefault(re.split("[-.]", name)[0], []).append(name)
    if not runs:
        raise InputError(f"{folder}: expected result files")
    rows = [[", ".join(f"`{names[0] if len(names) == 1 else os.path.commonprefix(names) + '*.json'}`"
                       for names in families.values()), *run]
            for run, families in sorted(runs.items(), key=lambda run: run[0][1], reverse=True)]
    return table(["files", "measured on", "date", "commit"], rows, words=4)


TABLES = {"files": files}
