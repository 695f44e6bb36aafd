# SPDX-License-Identifier: Apache-2.0
"""cmake/setup.sh with programs in place of apt-get and its like, the GPUs that presets build for, and licence lines."""
import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
STUBS = {
    "id": "echo 0",
    "dpkg-query": 'for name; do :; done\ncase " $MISSING " in *" $name "*) exit 1 ;; esac\necho installed',
    "apt-cache": 'case " $UNKNOWN " in *" $2 "*) echo "  Candidate: (none)" ;; *) echo "  Candidate: 1.0" ;; esac',
    "apt-get": 'echo "$*" >>"$CALLS"\nfor broken in $BROKEN; do case " $* " in *" $broken "*) exit 100 ;; esac; done',
}
SOURCES = (".c", ".cmake", ".cpp", ".css", ".cu", ".cuh", ".dox", ".h", ".hpp", ".html", ".in", ".inc", ".js", ".map",
           ".py", ".sh", ".toml")


def run_with(programs, command, **environment):
    """The command, with shell scripts `programs` in place of those of their names."""
    with tempfile.TemporaryDirectory() as folder:
        for name, body in programs.items():
            program = pathlib.Path(folder) / name
            program.write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
            program.chmod(0o755)
        calls = pathlib.Path(folder) / "calls"
        calls.touch()
        ran = subprocess.run(command, capture_output=True, text=True, check=False,
                             env={"PATH": f"{folder}:{os.environ['PATH']}", "CALLS": str(calls), **environment})
        return ran, [call.split()[-1] for call in calls.read_text(encoding="utf-8").splitlines()]


class Setup(unittest.TestCase):
    def setUp(self):
        lines = (line.split() for line in (ROOT / "cmake/packages.txt").read_text(encoding="utf-8").splitlines())
        parts = {words[1]: words[0] for words in lines if len(words) > 1 and words[0] != "#"}
        self.needed, self.optional = parts["test"], parts["test?"]

    def expect(self, code, said, installed, **environment):
        ran, calls = run_with(STUBS, [ROOT / "cmake/setup.sh", "test"], **environment)
        self.assertEqual((ran.returncode == 0, calls), (code == 0, installed))
        self.assertIn(said, ran.stdout + ran.stderr)

    def test_what_is_missing_is_installed_and_nothing_else_asks_the_network(self):
        self.expect(0, "", [])
        self.expect(0, "there is no package", [], MISSING=self.optional, UNKNOWN=self.optional)
        self.expect(0, "", ["update", self.needed, self.optional], MISSING=f"{self.needed} {self.optional}")

    def test_it_fails_without_what_is_needed_and_goes_on_without_what_is_optional(self):
        self.expect(0, f"going on without {self.optional}", ["update"], MISSING=self.optional, BROKEN="update")
        self.expect(0, "going on without it", ["update", self.optional], MISSING=self.optional, BROKEN=self.optional)
        self.expect(1, "expected a network", ["update"], MISSING=self.needed, BROKEN="update")
        self.expect(1, "", ["update", self.needed], MISSING=self.needed, BROKEN=self.needed)


class Sources(unittest.TestCase):
    def test_kernels_are_compiled_for_each_kind_of_gpu_here_that_nvcc_knows(self):
        with tempfile.NamedTemporaryFile("w", suffix=".cmake") as script:
            script.write(f'include("{ROOT}/cmake/NativeGpus.cmake")\nswiftgs_native_gpus(kinds)\nmessage("${{kinds}}")\n')
            script.flush()
            for nvidia_smi, kinds in (("printf '8.9\\n12.0\\n8.9\\n'", "89;120"), ("printf '7.0\\n7.5\\n'", "75"),
                                      ("echo 'NVIDIA-SMI has failed: no driver'; exit 9", "")):
                ran, _ = run_with({"nvidia-smi": nvidia_smi}, ["cmake", "-P", script.name])
                self.assertEqual((ran.returncode, ran.stderr), (0, kinds + "\n"), nvidia_smi)

    def test_every_source_file_names_its_licence(self):
        """In its first lines, behind what a program or a browser wants to read first."""
        folders = (".ci", "backends", "benchmarks", "cmake", "docs", "examples", "include", "tests")
        files = [path for folder in folders for path in (ROOT / folder).rglob("*")] + list(ROOT.iterdir())
        sources = [path for path in files if path.is_file() and
                   (path.suffix in SOURCES or path.name in ("CMakeLists.txt", "packages.txt", "run"))]
        self.assertGreater(len(sources), 500)
        self.assertEqual([str(path) for path in sources if "SPDX-License-Identifier: Apache-2.0" not in
                          "".join(path.read_text(encoding="utf-8").splitlines(keepends=True)[:3])], [])


if __name__ == "__main__":
    unittest.main()
