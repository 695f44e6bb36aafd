#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Injects each defect of table.py and runs the stability tests of the backend that has it.

    run.py BUILD [--quick] [--only WORDS] [--jobs N] [--compiler 'ccache c++'] [--include FOLDER]...

Works in the folder BUILD and leaves the sources alone: a mutant's file lies in a folder that the compiler searches
first. Reports which defects the tests noticed; exits with 1 where one went unnoticed or did not compile.
"""
import argparse
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
from table import MUTANTS  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
CPU = ROOT / "backends" / "cpu"
# One vector target, so that a mutant compiles once.
CPU_FLAGS = ["-O2", "-DHWY_COMPILE_ONLY_STATIC", "-DHWY_BASELINE_TARGETS=HWY_SSE4"]
# What the judge and the backend have in common must not replace each other at link time.
EXPORTS = "{ global: *CaseJudge*; local: *; };\n"


# What takes long and looks at no more than the rest.
LEFT_OUT = "--test-case-exclude=*large image*,*wide as images*"


class Tests:
    """The tests, compiled without a defect, and how to compile them with one."""

    def __init__(self, options):
        self.options = options
        self.compiler = shlex.split(options.compiler) + ["-std=c++20", "-w"]
        self.folder = pathlib.Path(options.build)
        self.system = [f"-isystem{folder}" for folder in options.include]

    def compile(self, source, output, flags, overlay=None):
        searched = [overlay / "include"] if overlay else []
        searched += [ROOT / "include", CPU / "include", ROOT / "tests"]
        folders = [f"-I{folder}" for folder in searched]
        call(self.compiler + ["-ffp-contract=off"] + folders + self.system + flags + ["-c", source, "-o", output])

    def compile_cpu(self, name, output, folder, overlay=None):
        self.compile(folder / name, output, CPU_FLAGS + [f"-I{folder}"], overlay)

    def link_judge(self, source_object, output):
        exports = self.folder / "judge.map"
        exports.write_text(EXPORTS)
        call(self.compiler + ["-shared", "-Wl,-Bsymbolic", f"-Wl,--version-script={exports}", source_object, "-o", output])

    def compile_judge(self, output, overlay=None):
        source_object = output.with_suffix(".o")
        self.compile(ROOT / "tests/stability/case_judge.cpp", source_object, ["-O2", "-fPIC"], overlay)
        self.link_judge(source_object, output)

    def compile_suite(self, backend, output, overlay=None):
        flags = ["-O1"] + (["-DSWIFTGS_MUTANT_CPU"] if backend == "cpu" else [])
        self.compile(HERE / "suite.cpp", output, flags, overlay)

    def prepare(self, backends):
        """Compiles all that no mutant of these backends changes."""
        self.folder.mkdir(parents=True, exist_ok=True)
        steps = [lambda: self.compile(ROOT / "tests/support/main.cpp", self.folder / "main.o", ["-O1"]),
                 lambda: self.compile_judge(self.folder / "judge.so")]
        if {"serial", "reference"} & backends:
            steps.append(lambda: self.compile_suite("serial", self.folder / "suite_serial.o"))
        if "cpu" in backends:
            steps.append(lambda: self.compile_suite("cpu", self.folder / "suite_cpu.o"))
            for source in CPU.glob("*.cpp"):
                output = self.folder / f"{source.stem}.o"
                steps.append(lambda name=source.name, output=output: self.compile_cpu(name, output, CPU))
        with ThreadPoolExecutor(self.options.jobs) as pool:
            for step in [pool.submit(step) for step in steps]:
                step.result()
        with ThreadPoolExecutor(self.options.jobs) as pool:
            for backend in {"serial" if backend == "reference" else backend for backend in backends}:
                pool.submit(self.expect_to_pass, backend).result()

    def expect_to_pass(self, backend):
        program = self.link(self.folder, backend, {})
        if subprocess.run([program, LEFT_OUT], stdout=subprocess.DEVNULL).returncode != 0:
            raise SystemExit(f"mutants: expected the tests of {backend} to pass without a defect; run {program}")

    def link(self, folder, backend, changed):
        """Links the tests of `backend`; `changed` maps names of objects to those that replace them."""
        names = ["main.o", "suite_cpu.o" if backend == "cpu" else "suite_serial.o", "judge.so"]
        names += [f"{source.stem}.o" for source in CPU.glob("*.cpp")] if backend == "cpu" else []
        objects = [changed.get(name, self.folder / name) for name in names]
        program = folder / f"test_{backend}"
        libraries = ["-lhwy", "-ltbb"] if backend == "cpu" else []
        call(self.compiler + objects + libraries + ["-o", program])
        return program

    def build(self, mutant, folder):
        """Compiles what the mutant changes and links it with the rest; the program's path."""
        backend = mutant.backend()
        if not mutant.file.startswith("backends/cpu/"):
            write(folder / mutant.file, mutated(mutant))
        if backend == "serial":
            self.compile_suite("serial", folder / "suite_serial.o", folder)
            return self.link(folder, "serial", {"suite_serial.o": folder / "suite_serial.o"})
        if backend == "reference":
            self.compile_judge(folder / "judge.so", folder)
            return self.link(folder, "serial", {"judge.so": folder / "judge.so"})
        sources = shutil.copytree(CPU, folder / "cpu")
        name = pathlib.Path(mutant.file).name
        if mutant.file.startswith("backends/cpu/"):
            write(sources / name, mutated(mutant))
        changed = {}
        for source in mutant.sources or (name,):
            output = folder / f"{pathlib.Path(source).stem}.o"
            self.compile_cpu(source, output, sources, folder)
            changed[output.name] = output
        return self.link(folder, "cpu", changed)


class Failed(Exception):
    pass


def call(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(done.stderr[-2000:])


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def mutated(mutant):
    text = (ROOT / mutant.file).read_text()
    if text.count(mutant.old) != 1:
        raise Failed(f"expected once in {mutant.file}: {mutant.old}\nfound {text.count(mutant.old)} times")
    return text.replace(mutant.old, mutant.new)


def try_mutant(tests, mutant):
    """Returns the outcome and what the tests said first."""
    folder = tests.folder / "".join(c if c.isalnum() else "_" for c in mutant.name)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        program = tests.build(mutant, folder)
    except Failed as error:
        return "not built", str(error)
    try:
        done = subprocess.run([program, "--abort-after=1", LEFT_OUT], capture_output=True, text=True, errors="replace", timeout=300)
    except subprocess.TimeoutExpired:
        return "killed", "takes more than 300 seconds"
    if not tests.options.keep:
        shutil.rmtree(folder)
    if done.returncode == 0:
        return "survived", ""
    cases = [line[len("TEST CASE:"):].strip() for line in done.stdout.splitlines() if line.startswith("TEST CASE:")]
    return "killed", (cases or ["crashes"])[0].removeprefix("mutant: ")


def chosen(options):
    wanted = [m for m in MUTANTS if (m.quick or not options.quick) and (m.name.startswith(options.only))]
    if not wanted:
        raise SystemExit(f"mutants: no mutant's name begins with '{options.only}'")
    return wanted


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--quick", action="store_true", help="the selection that ctest runs")
    parser.add_argument("--only", default="", metavar="WORDS", help="mutants whose name begins so")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--compiler", default=os.environ.get("CXX", "c++"))
    parser.add_argument("--include", action="append", default=["/usr/include/eigen3"], metavar="FOLDER")
    parser.add_argument("--keep", action="store_true", help="keep the programs of mutants")
    options = parser.parse_args()

    begun = time.time()
    mutants, tests = chosen(options), Tests(options)
    try:
        tests.prepare({mutant.backend() for mutant in mutants})
    except Failed as error:
        raise SystemExit(f"mutants: the tests do not compile without a defect\n{error}")
    counts = {}
    with ThreadPoolExecutor(options.jobs) as pool:
        for mutant, (outcome, why) in zip(mutants, pool.map(lambda m: try_mutant(tests, m), mutants)):
            if mutant.equivalent and outcome != "not built":
                outcome, why = ("equivalent", mutant.equivalent) if outcome == "survived" else ("not equivalent", why)
            counts[outcome] = counts.get(outcome, 0) + 1
            print(f"{outcome:10} {mutant.name}{': ' if why else ''}{why}", flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items())), end="")
    print(f" in {time.time() - begun:.0f} s")
    sys.exit(bool(set(counts) - {"killed", "equivalent"}))


if __name__ == "__main__":
    main()
