# SPDX-License-Identifier: Apache-2.0
"""The stability tests of the backends of the host."""
import pathlib
import shlex
import shutil

from common import BRIEFLY, HERE, ROOT, Failed, call, mutated, outcome_of, run_all, words_of, write

CPU = ROOT / "backends" / "cpu"
REFERENCE = ROOT / "backends" / "reference"
# One vector target, so that a mutant compiles once.
CPU_FLAGS = ["-O2", "-DHWY_COMPILE_ONLY_STATIC", "-DHWY_BASELINE_TARGETS=HWY_SSE4"]
# What the judge and the backend have in common must not replace each other at link time.
EXPORTS = "{ global: *CaseJudge*; local: *; };\n"


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

    def compile_judge(self, folder, reference=REFERENCE):
        """Links `judge.so`, which has the reference inside."""
        sources = [ROOT / "tests/stability/case_judge.cpp", *reference.glob("*.cpp")]
        objects = [folder / f"judge_{source.stem}.o" for source in sources]
        for source, output in zip(sources, objects):
            self.compile(source, output, ["-O2", "-fPIC"])
        exports = self.folder / "judge.map"
        exports.write_text(EXPORTS)
        flags = ["-shared", "-Wl,-Bsymbolic", f"-Wl,--version-script={exports}"]
        call(self.compiler + flags + objects + ["-o", folder / "judge.so"])

    def compile_suite(self, backend, output, overlay=None):
        flags = ["-O1"] + (["-DSWIFTGS_MUTANT_CPU"] if backend == "cpu" else [])
        self.compile(HERE / "suite.cpp", output, flags, overlay)

    def prepare(self, backends):
        """Compiles all that no mutant of these backends changes."""
        self.folder.mkdir(parents=True, exist_ok=True)
        suites = {"serial" if backend == "reference" else backend for backend in backends}
        steps = [(self.compile, ROOT / "tests/support/main.cpp", self.folder / "main.o", ["-O1"]),
                 (self.compile_judge, self.folder)]
        steps += [(self.compile_suite, backend, self.folder / f"suite_{backend}.o") for backend in suites]
        if "cpu" in backends:
            steps += [(self.compile_cpu, source.name, self.folder / f"{source.stem}.o", CPU)
                      for source in CPU.glob("*.cpp")]
        run_all(steps, self.options.jobs)
        for backend in suites:
            self.expect_to_pass(backend)

    def expect_to_pass(self, backend):
        program = self.link(self.folder, backend, {})
        if outcome_of([program, *BRIEFLY])[0] != "survived":
            raise SystemExit(f"mutants: expected the tests of {backend} to pass without a defect; run {program}")

    def link(self, folder, backend, changed):
        """Links the tests of `backend`; `changed` maps names of objects to those that replace them."""
        names = ["main.o", f"suite_{backend}.o", "judge.so"]
        names += [f"{source.stem}.o" for source in CPU.glob("*.cpp")] if backend == "cpu" else []
        objects = [changed.get(name, self.folder / name) for name in names]
        program = folder / f"test_{backend}"
        libraries = ["-lhwy", "-ltbb"] if backend == "cpu" else []
        call(self.compiler + objects + libraries + ["-o", program])
        return program

    def build(self, mutant, folder):
        """Compiles what the mutant changes and links it with the rest; the program's path."""
        backend = mutant.backend()
        if not mutant.file.startswith("backends/"):
            write(folder / mutant.file, mutated(mutant))
        if backend == "serial":
            self.compile_suite("serial", folder / "suite_serial.o", folder)
            return self.link(folder, "serial", {"suite_serial.o": folder / "suite_serial.o"})
        if backend == "reference":
            sources = shutil.copytree(REFERENCE, folder / "reference")
            write(sources / pathlib.Path(mutant.file).name, mutated(mutant))
            self.compile_judge(folder, sources)
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

    def try_mutant(self, mutant):
        """Returns the outcome and what the tests said first."""
        folder = self.folder / words_of(mutant)
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        try:
            program = self.build(mutant, folder)
        except Failed as error:
            return "not built", str(error)
        outcome = outcome_of([program, *BRIEFLY])
        if not self.options.keep:
            shutil.rmtree(folder)
        return outcome
