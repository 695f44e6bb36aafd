# SPDX-License-Identifier: Apache-2.0
"""The stability tests of the cuda backend."""
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor

from common import BRIEFLY, HERE, ROOT, Failed, call, chosen, mutated, outcome_of, report, run_all, words_of, write

CUDA = ROOT / "backends" / "cuda"
# What the tests link beside the backend.
BESIDE = [source for name in ("builtin", "reference") for source in sorted((ROOT / "backends" / name).glob("*.cpp"))]
# Sources of the cuda backend that are compiled without fused multiply-adds.
UNFUSED = re.search(r"set_source_files_properties\(([^)]*?)PROPERTIES COMPILE_OPTIONS -fmad=false",
                    (CUDA / "CMakeLists.txt").read_text())[1].split()


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
        program = {ROOT / "tests/support/main.cpp": "main.o", ROOT / "tests/stability/case_judge.cpp": "judge.o"}
        program.update({source: f"{source.parent.name}_{source.stem}.o" for source in BESIDE})
        suite = self.folder / "suite_cuda.o"
        steps = [(self.compile_host, source, self.folder / name) for source, name in program.items()]
        steps += [(self.compile_host, HERE / "suite.cpp", suite, ["-DSWIFTGS_MUTANT_CUDA"])]
        steps += [(self.compile_library, source, self.folder / f"cuda_{source.stem}.o") for source in self.sources()]
        run_all(steps, self.options.jobs)
        self.link_library(out / "none", {})
        objects = [self.folder / name for name in program.values()] + [suite]
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
    whole = subprocess.run([program, *BRIEFLY], capture_output=True, text=True, errors="replace",
                           env=environment("none"))
    skipped = re.search(r"skipped: (.*)", whole.stdout)
    if whole.returncode != 0 or skipped:
        said = skipped[1] if skipped else whole.stdout[-2000:] + whole.stderr[-2000:]
        raise SystemExit(f"mutants: expected the tests to pass without a defect, none skipped\n{said}")
    with ThreadPoolExecutor(options.jobs) as pool:
        outcomes = pool.map(lambda mutant: outcome_of([program, *BRIEFLY], environment(words_of(mutant))), mutants)
        return report(mutants, outcomes, begun)
