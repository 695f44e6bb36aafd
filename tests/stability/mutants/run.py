#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Injects each defect of table.py and runs the stability tests of the backend that has it.

    run.py BUILD [--quick] [--only WORDS] [--jobs N] [--compiler 'ccache c++'] [--include FOLDER]...
    run.py BUILD --build-only FOLDER [--only WORDS] [--nvcc nvcc] [--architecture 90]
    run.py --run FOLDER [--only WORDS] [--jobs N]

Works in the folder BUILD and leaves the sources alone: a mutant's file lies in a folder that the compiler searches
first. Reports which defects the tests noticed; exits with 1 where one went unnoticed or did not compile.

The first form tries the defects of the host's backends. Those of the cuda backend need nvcc, and then a GPU: the second
form builds them on any machine with nvcc, the third runs what lies in FOLDER on a machine with a GPU.
"""
import argparse
import json
import os
import pathlib
import re
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
CUDA = ROOT / "backends" / "cuda"
# One vector target, so that a mutant compiles once.
CPU_FLAGS = ["-O2", "-DHWY_COMPILE_ONLY_STATIC", "-DHWY_BASELINE_TARGETS=HWY_SSE4"]
# What the judge and the backend have in common must not replace each other at link time.
EXPORTS = "{ global: *CaseJudge*; local: *; };\n"


# Sources of the cuda backend that are compiled without fused multiply-adds.
UNFUSED = re.search(r"set_source_files_properties\(([^)]*?)PROPERTIES COMPILE_OPTIONS -fmad=false",
                    (CUDA / "CMakeLists.txt").read_text())[1].split()

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
        flags = ["-shared", "-Wl,-Bsymbolic", f"-Wl,--version-script={exports}"]
        call(self.compiler + flags + [source_object, "-o", output])

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


class CudaTests:
    """The tests of the cuda backend, and the backend as a shared library that is replaced for each mutant.

    The defect is in the library alone: the program and its inline functions are the same for all.
    """

    def __init__(self, options):
        self.options = options
        self.folder = pathlib.Path(options.build)
        self.system = [f"-isystem={folder}" for folder in options.include]
        self.nvcc = shlex.split(options.nvcc) + ["-std=c++20", "-w", f"-arch=sm_{options.architecture}"]

    def compile_host(self, source, output, flags=()):
        folders = [f"-I{folder}" for folder in (ROOT / "include", CUDA / "include", ROOT / "tests")]
        flags = ["-O1", "-Xcompiler=-ffp-contract=off,-fPIC", *flags]
        call(self.nvcc + folders + self.system + flags + ["-c", source, "-o", output])

    def compile_library(self, source, output, overlay=None):
        """Headers beside `source` are its own; others are those of `overlay`, where it has them."""
        searched = [overlay / "include"] if overlay else []
        searched += [source.parent / "include", ROOT / "include"]
        flags = ["-O3", "-DNDEBUG", "-Xcompiler=-fPIC,-fvisibility=hidden"]
        flags += ["-fmad=false"] if source.name in UNFUSED else []
        call(self.nvcc + [f"-I{folder}" for folder in searched] + flags + ["-c", source, "-o", output])

    def sources(self):
        return sorted(CUDA.glob("*.cu")) + sorted(CUDA.glob("*.cpp"))

    def link_library(self, folder, changed):
        """Links the backend into `folder`; `changed` maps names of objects to those that replace them."""
        names = [f"cuda_{source.stem}.o" for source in self.sources()]
        objects = [changed.get(name, self.folder / name) for name in names]
        folder.mkdir(parents=True, exist_ok=True)
        call(self.nvcc + ["-shared", "-Xlinker=-s,-soname=libbackend.so"] + objects + ["-o", folder / "libbackend.so"])

    def prepare(self, out):
        """Compiles all that no mutant changes, and links it."""
        self.folder.mkdir(parents=True, exist_ok=True)
        out.mkdir(parents=True, exist_ok=True)
        steps = [lambda: self.compile_host(ROOT / "tests/support/main.cpp", self.folder / "main.o"),
                 lambda: self.compile_host(ROOT / "tests/stability/case_judge.cpp", self.folder / "judge.o"),
                 lambda: self.compile_host(HERE / "suite.cpp", self.folder / "suite_cuda.o", ["-DSWIFTGS_MUTANT_CUDA"])]
        for source in self.sources():
            output = self.folder / f"cuda_{source.stem}.o"
            steps.append(lambda source=source, output=output: self.compile_library(source, output))
        with ThreadPoolExecutor(self.options.jobs) as pool:
            for step in [pool.submit(step) for step in steps]:
                step.result()
        self.link_library(out / "none", {})
        objects = [self.folder / name for name in ("main.o", "judge.o", "suite_cuda.o")]
        call(self.nvcc + objects + [out / "none/libbackend.so", "-Xlinker=-s", "-o", out / "suite"])

    def build(self, mutant, out):
        """Builds the backend that has the defect; the reason why it does not compile, or nothing."""
        folder = self.folder / words_of(mutant)
        shutil.rmtree(folder, ignore_errors=True)
        try:
            sources = shutil.copytree(CUDA, folder / "cuda")
            inside = mutant.file.startswith("backends/cuda/")
            write(folder / (mutant.file.removeprefix("backends/") if inside else mutant.file), mutated(mutant))
            changed = {}
            for name in mutant.sources or (pathlib.Path(mutant.file).name,):
                output = folder / f"cuda_{pathlib.Path(name).stem}.o"
                self.compile_library(sources / name, output, folder)
                changed[output.name] = output
            self.link_library(out / words_of(mutant), changed)
        except Failed as error:
            return str(error)
        if not self.options.keep:
            shutil.rmtree(folder)
        return ""


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
    for old, new in ((mutant.old, mutant.new), *mutant.also):
        if text.count(old) != 1:
            raise Failed(f"expected once in {mutant.file}: {old}\nfound {text.count(old)} times")
        text = text.replace(old, new)
    return text


def words_of(mutant):
    return "".join(c if c.isalnum() else "_" for c in mutant.name)


def outcome_of(program, environment=None):
    """Runs the tests: the outcome and what they said first."""
    try:
        done = subprocess.run([program, "--abort-after=1", LEFT_OUT], capture_output=True, text=True, errors="replace",
                              timeout=300, env=environment)
    except subprocess.TimeoutExpired:
        return "killed", "takes more than 300 seconds"
    if done.returncode == 0:
        return "survived", ""
    cases = [line[len("TEST CASE:"):].strip() for line in done.stdout.splitlines() if line.startswith("TEST CASE:")]
    return "killed", (cases or ["crashes"])[0].removeprefix("mutant: ")


def check_table():
    """Every mutant's texts must be in the sources, whichever are tried."""
    errors = []
    for mutant in MUTANTS:
        try:
            mutated(mutant)
        except Failed as error:
            errors.append(f"{mutant.name}: {error}")
    if errors:
        raise SystemExit("mutants: update table.py\n" + "\n".join(errors))


def try_mutant(tests, mutant):
    """Returns the outcome and what the tests said first."""
    folder = tests.folder / words_of(mutant)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        program = tests.build(mutant, folder)
    except Failed as error:
        return "not built", str(error)
    outcome = outcome_of(program)
    if not tests.options.keep:
        shutil.rmtree(folder)
    return outcome


def chosen(options, of_cuda):
    wanted = [m for m in MUTANTS if (m.backend() == "cuda") == of_cuda and (m.quick or not options.quick)
              and m.name.startswith(options.only)]
    if not wanted:
        raise SystemExit(f"mutants: no mutant's name begins with '{options.only}'")
    return wanted


def report(mutants, outcomes, begun):
    """Prints each outcome as it comes, and their counts; whether each mutant is as the table says."""
    counts = {}
    for mutant, (outcome, why) in zip(mutants, outcomes):
        if mutant.equivalent and outcome != "not built":
            outcome, why = ("equivalent", mutant.equivalent) if outcome == "survived" else ("not equivalent", why)
        counts[outcome] = counts.get(outcome, 0) + 1
        print(f"{outcome:10} {mutant.name}{': ' if why else ''}{why}", flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items())), end="")
    print(f" in {time.time() - begun:.0f} s")
    return not set(counts) - {"killed", "equivalent"}


def build_cuda(options):
    """Leaves the program and a backend for each mutant in a folder, with a list of them."""
    mutants, tests, out = chosen(options, True), CudaTests(options), pathlib.Path(options.build_only)
    begun = time.time()
    try:
        tests.prepare(out)
    except Failed as error:
        raise SystemExit(f"mutants: the tests do not compile without a defect\n{error}")
    print(f"built the tests in {time.time() - begun:.0f} s", flush=True)
    built = []
    with ThreadPoolExecutor(options.jobs) as pool:
        for mutant, error in zip(mutants, pool.map(lambda m: tests.build(m, out), mutants)):
            print(f"{'not built' if error else 'built':10} {mutant.name}{': ' if error else ''}{error}", flush=True)
            if not error:
                built.append(mutant.name)
    (out / "mutants.json").write_text(json.dumps(built, indent=1) + "\n")
    print(f"{len(built)} of {len(mutants)} built in {time.time() - begun:.0f} s; run them where a GPU is: "
          f"run.py --run {out}")
    return len(built) == len(mutants)


def run_cuda(options):
    """Runs what `build_cuda` left."""
    folder = pathlib.Path(options.run).resolve()
    names = json.loads((folder / "mutants.json").read_text())
    mutants = [mutant for mutant in chosen(options, True) if mutant.name in names]

    def environment(of):
        paths = [str(folder / of)] + [path for path in [os.environ.get("LD_LIBRARY_PATH")] if path]
        return {**os.environ, "LD_LIBRARY_PATH": ":".join(paths)}

    begun = time.time()
    program = folder / "suite"
    whole = subprocess.run([program, LEFT_OUT], capture_output=True, text=True, errors="replace",
                           env=environment("none"))
    skipped = re.search(r"skipped: (.*)", whole.stdout)
    if whole.returncode != 0 or skipped:
        said = skipped[1] if skipped else whole.stdout[-2000:] + whole.stderr[-2000:]
        raise SystemExit(f"mutants: expected the tests to pass without a defect, none skipped\n{said}")
    with ThreadPoolExecutor(options.jobs) as pool:
        outcomes = pool.map(lambda mutant: outcome_of(program, environment(words_of(mutant))), mutants)
        return report(mutants, outcomes, begun)


def run_host(options):
    begun = time.time()
    mutants, tests = chosen(options, False), Tests(options)
    try:
        tests.prepare({mutant.backend() for mutant in mutants})
    except Failed as error:
        raise SystemExit(f"mutants: the tests do not compile without a defect\n{error}")
    with ThreadPoolExecutor(options.jobs) as pool:
        return report(mutants, pool.map(lambda mutant: try_mutant(tests, mutant), mutants), begun)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?")
    parser.add_argument("--build-only", metavar="FOLDER", help="build the mutants of the cuda backend into FOLDER")
    parser.add_argument("--run", metavar="FOLDER", help="run what --build-only left there")
    parser.add_argument("--nvcc", default="nvcc")
    parser.add_argument("--architecture", default="90", help="compute capability of the GPU, without its point")
    parser.add_argument("--quick", action="store_true", help="the selection that ctest runs")
    parser.add_argument("--only", default="", metavar="WORDS", help="mutants whose name begins so")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--compiler", default=os.environ.get("CXX", "c++"))
    parser.add_argument("--include", action="append", default=["/usr/include/eigen3"], metavar="FOLDER")
    parser.add_argument("--keep", action="store_true", help="keep the programs of mutants")
    options = parser.parse_args()

    if options.run:
        sys.exit(not run_cuda(options))
    if not options.build:
        parser.error("expected the folder BUILD")
    check_table()
    sys.exit(not (build_cuda(options) if options.build_only else run_host(options)))


if __name__ == "__main__":
    main()
