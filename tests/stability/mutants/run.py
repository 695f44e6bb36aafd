#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Injects each defect of defects.py, one at a time, and runs the stability tests of the backend that has it.

    run.py BUILD [--only WORDS] [--jobs N] [--compiler 'ccache c++'] [--include FOLDER]... [--keep]

Works in the folder BUILD and leaves the sources alone: the file with a defect lies in a folder that the compiler
searches first. Reports which defects the tests noticed; exits with 1 where one went unnoticed or did not compile.
"""
import argparse
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
from defects import DEFECTS  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
CPU = ROOT / "backends/cpu"
JUDGE = [ROOT / "tests/stability/case_judge.cpp", *(ROOT / "backends/parts/reference").glob("*.cpp")]
# One vector target, so that a defect compiles once.
CPU_FLAGS = ["-O2", "-DHWY_COMPILE_ONLY_STATIC", "-DHWY_BASELINE_TARGETS=HWY_SSE4"]
# Functions that the judge and a backend have in common must not replace each other at link time.
EXPORTS = "{ global: *CaseJudge*; local: *; };\n"
# Without what takes long and looks at no more than the rest.
BRIEFLY = ["--abort-after=1", "--test-case-exclude=*large image*,*wide as images*"]


class Failed(Exception):
    pass


def call(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed((done.stderr or done.stdout)[-2000:])


def outcome_of(program):
    """Runs tests: the outcome and what they said first."""
    try:
        done = subprocess.run([program, *BRIEFLY], capture_output=True, text=True, errors="replace", timeout=300)
    except subprocess.TimeoutExpired:
        return "noticed", "takes more than 300 seconds"
    if done.returncode == 0:
        return "survived", ""
    cases = [line[len("TEST CASE:"):].strip() for line in done.stdout.splitlines() if line.startswith("TEST CASE:")]
    return "noticed", (cases or done.stderr.splitlines() or ["crashes"])[0]


def injected(defect):
    text = (ROOT / defect.file).read_text()
    for old, new in defect.changes:
        if text.count(old) != 1:
            raise Failed(f"expected once in {defect.file}: {old}\nfound {text.count(old)} times")
        text = text.replace(old, new)
    return text


class Tests:
    """The tests, compiled without a defect, and how to compile them with one."""

    def __init__(self, options):
        self.compiler = shlex.split(options.compiler) + ["-std=c++20", "-w"]
        self.system = [f"-isystem{folder}" for folder in options.include]
        self.folder, self.keep = pathlib.Path(options.build), options.keep

    def compile(self, source, output, flags, overlay=None):
        searched = [overlay / "include"] if overlay else []
        searched += [ROOT / "include", CPU / "include", ROOT / "tests"]
        folders = [f"-I{folder}" for folder in searched]
        call(self.compiler + ["-ffp-contract=off"] + folders + self.system + flags + ["-c", source, "-o", output])

    def compile_suite(self, backend, output, overlay=None):
        self.compile(HERE / "suite.cpp", output, ["-O1"] + ["-DSWIFTGS_MUTANT_CPU"] * (backend == "cpu"), overlay)

    def prepare(self, backends, jobs):
        """Compiles all that no defect changes. The judge becomes a library that has the reference inside."""
        self.folder.mkdir(parents=True, exist_ok=True)
        objects = [self.folder / f"judge_{source.stem}.o" for source in JUDGE]
        steps = [(self.compile, ROOT / "tests/support/main.cpp", self.folder / "main.o", ["-O1"])]
        steps += [(self.compile, source, output, ["-O2", "-fPIC"]) for source, output in zip(JUDGE, objects)]
        steps += [(self.compile_suite, backend, self.folder / f"suite_{backend}.o") for backend in backends]
        if "cpu" in backends:
            steps += [(self.compile, source, self.folder / f"{source.stem}.o", CPU_FLAGS + [f"-I{CPU}"])
                      for source in CPU.glob("*.cpp")]
        with ThreadPoolExecutor(jobs) as pool:
            for step in [pool.submit(*step) for step in steps]:
                step.result()
        exports = self.folder / "judge.map"
        exports.write_text(EXPORTS)
        call(self.compiler + ["-shared", "-Wl,-Bsymbolic", f"-Wl,--version-script={exports}"] + objects +
             ["-o", self.folder / "judge.so"])
        for backend in backends:
            program = self.link(self.folder, backend, {})
            if outcome_of(program)[0] != "survived":
                raise SystemExit(f"mutants: expected the tests of {backend} to pass without a defect; run {program}")

    def link(self, folder, backend, changed):
        """Links the tests of `backend`; `changed` maps names of objects to those that replace them."""
        names = ["main.o", f"suite_{backend}.o", "judge.so"]
        names += [f"{source.stem}.o" for source in CPU.glob("*.cpp")] if backend == "cpu" else []
        objects = [changed.get(name, self.folder / name) for name in names]
        program = folder / f"test_{backend}"
        call(self.compiler + objects + ["-lhwy", "-ltbb"] * (backend == "cpu") + ["-o", program])
        return program

    def build(self, defect, folder):
        """Compiles what the defect changes and links it with the rest; the program's path."""
        of_cpu = defect.file.startswith("backends/cpu/")
        copy = folder / (defect.file.removeprefix("backends/") if of_cpu else defect.file)
        if of_cpu:
            shutil.copytree(CPU, folder / "cpu")
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_text(injected(defect))
        if not of_cpu:
            self.compile_suite("serial", folder / "suite_serial.o", folder)
            return self.link(folder, "serial", {"suite_serial.o": folder / "suite_serial.o"})
        changed = {}
        for source in defect.sources:
            output = folder / f"{pathlib.Path(source).stem}.o"
            self.compile(folder / "cpu" / source, output, CPU_FLAGS + [f"-I{folder / 'cpu'}"])
            changed[output.name] = output
        return self.link(folder, "cpu", changed)

    def attempt(self, defect):
        """The outcome and what the tests said first."""
        folder = self.folder / "".join(c if c.isalnum() else "_" for c in defect.name)
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        try:
            outcome, why = outcome_of(self.build(defect, folder))
        except Failed as error:
            return "not built", str(error)
        if not self.keep:
            shutil.rmtree(folder)
        if defect.equivalent:
            return ("equivalent", defect.equivalent) if outcome == "survived" else ("not equivalent", why)
        return outcome, why


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", metavar="BUILD")
    parser.add_argument("--only", default="", metavar="WORDS", help="defects whose name begins so")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--compiler", default=os.environ.get("CXX", "c++"))
    parser.add_argument("--include", action="append", default=["/usr/include/eigen3"], metavar="FOLDER")
    parser.add_argument("--keep", action="store_true", help="keep the programs with defects")
    options = parser.parse_args()

    wanted = [defect for defect in DEFECTS if defect.name.startswith(options.only)]
    if not wanted:
        raise SystemExit(f"mutants: no defect's name begins with '{options.only}'")
    tests, counts = Tests(options), {}
    try:
        tests.prepare({"cpu" if defect.file.startswith("backends/cpu/") else "serial" for defect in wanted},
                      options.jobs)
    except Failed as error:
        raise SystemExit(f"mutants: the tests do not compile without a defect\n{error}")
    with ThreadPoolExecutor(options.jobs) as pool:
        for defect, (outcome, why) in zip(wanted, pool.map(tests.attempt, wanted)):
            counts[outcome] = counts.get(outcome, 0) + 1
            print(f"{outcome:10} {defect.name}{': ' if why else ''}{why}", flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items())))
    sys.exit(bool(set(counts) - {"noticed", "equivalent"}))


if __name__ == "__main__":
    main()
