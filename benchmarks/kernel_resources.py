#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Registers and spills of every kernel, as ptxas reports them: kernel_resources.py BUILD TABLE.csv [FILE.cu...].

Compiles the kernels of BUILD, a configured build with CUDA, once more for each of its architectures, and writes TABLE
anew. What it has of other files and architectures stays. Fails when a kernel spills that did not, or spills more.
A row is a kernel, a column an architecture: registers, and behind a plus sign bytes that are spilled.
"""
import concurrent.futures
import csv
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys


def commands(build, only):
    """(file, architecture, command) of each compilation."""
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        path = pathlib.Path(entry["file"])
        if path.suffix != ".cu" or "backends" not in path.parts or only and path.name not in only:
            continue
        words = [word for word in shlex.split(entry["command"]) if not word.startswith("--generate-code=")]
        words = words[next(i for i, word in enumerate(words) if word.endswith("nvcc")):]  # without a launcher
        at = words.index("-o")
        words = [word for word in words[:at] + words[at + 2:] if word != "-c"]
        for architecture in sorted({int(number) for number in re.findall(r"sm_(\d+)", entry["command"])}):
            how = ["-cubin", f"-arch=sm_{architecture}", "-Xptxas", "-v", "-o", os.devnull]
            yield path.name, architecture, words + how


def parse(report):
    """(kernel, registers, bytes stored by spills) from what `ptxas -v` says."""
    name = spilled = None
    for line in report.splitlines():
        if found := re.search(r"Compiling entry function '(.*)' for", line):
            name = found[1]
        elif found := re.search(r"(\d+) bytes spill stores", line):
            spilled = int(found[1])
        elif (found := re.search(r"Used (\d+) registers", line)) and name:
            yield name, int(found[1]), spilled
            name = None


def readable(names):
    """Without the namespaces and arguments that all have."""
    said = subprocess.run(["c++filt"], input="\n".join(names), check=True, stdout=subprocess.PIPE, text=True).stdout
    for name in said.splitlines():
        name = re.sub(r"\bswiftgs::(?:kernels::)?|\(anonymous namespace\)::|^void ", "", name)
        depth = 0
        for at, letter in enumerate(name):
            depth += {"<": 1, ">": -1}.get(letter, 0)
            if letter == "(" and depth == 0:
                name = name[:at]
                break
        yield name


def measure(job):
    file, architecture, command = job
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"kernel_resources: {file} does not compile for sm_{architecture}:\n{done.stdout}")
    rows = list(parse(done.stdout))
    return [(file, name, architecture, *numbers)
            for name, (_, *numbers) in zip(readable([row[0] for row in rows]), rows, strict=True)
            if not name.startswith("cub::")]  # NVIDIA's own


def read(table):
    if not table.exists():
        return {}
    with table.open(encoding="utf-8", newline="") as file:
        return {(row["file"], row["kernel"], int(name)): tuple(map(int, f"{cell}+0".split("+")[:2]))
                for row in csv.DictReader(file) for name, cell in row.items() if name.isdigit() and cell}


def write(table, rows):
    architectures = sorted({architecture for _, _, architecture in rows})
    with table.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["file", "kernel", *architectures])
        for file_and_kernel in sorted({key[:2] for key in rows}):
            cells = [rows.get((*file_and_kernel, architecture)) for architecture in architectures]
            writer.writerow([*file_and_kernel, *("" if cell is None else f"{cell[0]}+{cell[1]}" if cell[1] else cell[0]
                                                 for cell in cells)])


def regressions(before, after):
    """A line for each kernel that spills more than before. A new one must not, in a file that was measured before."""
    known = {(file, architecture) for file, _, architecture in before}
    found = []
    for file, kernel, architecture in sorted(after):
        spilled, allowed = (rows.get((file, kernel, architecture), (0, 0))[1] for rows in (after, before))
        if spilled > allowed and (file, architecture) in known:
            found.append(f"{file}: {kernel} spills {spilled} bytes on sm_{architecture}, expected at most {allowed}")
    return found


def main(build, table, *only):
    build, table = pathlib.Path(build), pathlib.Path(table)
    jobs = list(commands(build, only))
    if not jobs:
        sys.exit(f"kernel_resources: {build}: expected a build with CUDA and the files {' '.join(only) or '*.cu'}")
    before, measured, compiled = read(table), {}, set()
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", "1"))) as pool:
        for (file, architecture, _), rows in zip(jobs, pool.map(measure, jobs), strict=True):
            compiled.add((file, architecture))
            measured |= {row[:3]: row[3:] for row in rows}
            kept = {key: row for key, row in before.items() if (key[0], key[2]) not in compiled}
            write(table, kept | measured)
    if worse := regressions(before, measured):
        write(table, measured | before)  # or the next run would compare with the worse ones
        sys.exit("\n".join(worse))


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit("usage: kernel_resources.py BUILD TABLE.csv [FILE.cu...]")
    main(*sys.argv[1:])
