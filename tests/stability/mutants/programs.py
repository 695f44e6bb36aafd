# SPDX-License-Identifier: Apache-2.0
"""Programs of the tests, for mutants that name one: built by CMake in a copy of the project, without CUDA."""
import pathlib
import shlex
import shutil

from common import ROOT, Failed, call, mutated, outcome_of

# One vector target, and no warnings: a defect may leave a variable without a use.
FLAGS = "-O1 -w -DHWY_COMPILE_ONLY_STATIC"
LEFT_OUT = ("BENCHMARKS", "CUDA", "EXAMPLES", "PYTHON")


class Programs:
    def __init__(self, options):
        self.options = options
        self.sources, self.built = (pathlib.Path(options.build) / name for name in ("tree", "programs"))

    def prepare(self, tests):
        """Builds the programs of `tests` without a defect and runs them."""
        self.copy_sources()
        compiler = shlex.split(self.options.compiler)
        launcher = [f"-DCMAKE_CXX_COMPILER_LAUNCHER={';'.join(compiler[:-1])}"] if len(compiler) > 1 else []
        call(["cmake", "-S", self.sources, "-B", self.built, "-G", "Ninja", f"-DCMAKE_CXX_COMPILER={compiler[-1]}",
              f"-DCMAKE_CXX_FLAGS={FLAGS}"] + launcher + [f"-DSWIFTGS_BUILD_{part}=OFF" for part in LEFT_OUT])
        for test in sorted(tests):
            if outcome_of(self.build(test))[0] != "survived":
                raise SystemExit(f"mutants: expected '{test}' to pass without a defect; run it in {self.built}/tests")

    def copy_sources(self):
        """Writes only what differs, so that little is compiled again."""
        for name in call(["git", "-C", ROOT, "ls-files", "-coz", "--exclude-standard"]).split("\0"):
            source, copy = ROOT / name, self.sources / name
            if source.is_file() and not (copy.is_file() and copy.read_bytes() == source.read_bytes()):
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source, copy)

    def build(self, test):
        """Compiles the program of `test`; the command that runs it."""
        command = [self.built / "tests" / word if "/" in word else word for word in test.split()]
        programs = [word.name for word in command if isinstance(word, pathlib.Path) and word.name != "launch"]
        call(["ninja", "-C", self.built, "-j", str(self.options.jobs), *programs])
        return command

    def try_mutant(self, mutant):
        """Returns the outcome and what the test said first."""
        copy = self.sources / mutant.file
        try:
            text = mutated(mutant)
            copy.write_text(text)
            return outcome_of(self.build(mutant.test))
        except Failed as error:
            return "not built", str(error)
        finally:
            shutil.copy(ROOT / mutant.file, copy)
