# SPDX-License-Identifier: Apache-2.0
"""Licence lines and shell scripts of the repository, and the last lines of test.sh, with a program in place of cmake."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FOLDERS = ("", ".ci", "benchmarks", "cmake", "docs")
JUNIT = """<testsuite tests="4"
	failures="0"
	disabled="0"
	skipped="3"
	>
	<testcase name="a" status="notrun">
		<skipped message="SKIP_RETURN_CODE=77"/>
		<system-out>[doctest] a
support/main.cpp:40: MESSAGE: skipped: no Chromium here (package chromium)
</system-out>
	</testcase>
	<testcase name="b" status="notrun">
		<skipped message="SKIP_RETURN_CODE=77"/>
		<system-out>support/main.cpp:40: MESSAGE: skipped: no Chromium here (package chromium)
</system-out>
	</testcase>
	<testcase name="c" status="notrun">
		<skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/>
		<system-out>skipped: no doxygen here (package doxygen)
</system-out>
	</testcase>
	<testcase name="d" status="run">
		<system-out>skipped: but this one ran
</system-out>
	</testcase>
</testsuite>
"""
CMAKE = """#!/bin/sh
mkdir -p "build/$3"
[ "$3" != release ] || cp junit.txt build/release/junit.xml
"""


SOURCES = (".c", ".cmake", ".cpp", ".css", ".cu", ".cuh", ".dox", ".h", ".hpp", ".html", ".in", ".inc", ".js", ".map",
           ".py", ".sh", ".toml")


class Licences(unittest.TestCase):
    def test_every_source_file_names_its_licence(self):
        """In its first lines, behind what a program or a browser wants to read first."""
        folders = (".ci", "backends", "benchmarks", "cmake", "docs", "examples", "include", "tests")
        files = [path for folder in folders for path in (ROOT / folder).rglob("*")] + list(ROOT.iterdir())
        sources = [path for path in files if path.is_file() and
                   (path.suffix in SOURCES or path.name in ("CMakeLists.txt", "packages.txt", "run"))]
        self.assertGreater(len(sources), 900)
        without = [str(path.relative_to(ROOT)) for path in sources
                   if not any("SPDX-License-Identifier: Apache-2.0" in line
                              for line in path.read_text(encoding="utf-8").splitlines()[:3])]
        self.assertEqual(without, [])


class Scripts(unittest.TestCase):
    def test_no_reader_of_a_pipe_leaves_early(self):
        """Its writer would die of SIGPIPE, and pipefail would make that a failure."""
        scripts = [path for folder in FOLDERS for path in (ROOT / folder).iterdir()
                   if path.is_file() and path.read_bytes().startswith(b"#!/usr/bin/env bash")]
        self.assertGreater(len(scripts), 5)
        early = re.compile(r"\|\s*(?:grep\s+(?:-\w*[qlm]|--quiet|--max-count)|head\b|sed\b[^|]*[0-9;/ ]q\b)")
        found = [f"{path.name}: {line}" for path in scripts for line in path.read_text(encoding="utf-8").splitlines()
                 if early.search(line)]
        self.assertEqual(found, [])

    def test_nvcc_knows_the_flags_of_a_machine_without_a_gpu(self):
        nvcc = shutil.which("nvcc") or shutil.which("nvcc", path="/usr/local/cuda/bin")
        if not nvcc:
            self.skipTest("no nvcc here")
        flags = re.search(r'CUDAFLAGS \}([^"]+)"', (ROOT / "test.sh").read_text(encoding="utf-8"))[1].split()
        with tempfile.TemporaryDirectory() as folder:
            source = pathlib.Path(folder) / "empty.cu"
            source.write_text("", encoding="utf-8")
            ran = subprocess.run([nvcc, *flags, "--dryrun", "-c", source], cwd=folder, capture_output=True, text=True,
                                 check=False)
        self.assertEqual(ran.returncode, 0, ran.stderr)

    def test_the_last_lines_of_a_run_name_what_was_missing(self):
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            shutil.copy(ROOT / "test.sh", place)
            (place / "junit.txt").write_text(JUNIT, encoding="utf-8")
            for name, text in (("cmake/setup.sh", "#!/bin/sh\n"), ("bin/cmake", CMAKE), ("bin/clang++", "#!/bin/sh\n")):
                (place / name).parent.mkdir(exist_ok=True)
                (place / name).write_text(text, encoding="utf-8")
                (place / name).chmod(0o755)
            ran = subprocess.run([str(place / "test.sh")], capture_output=True, text=True, check=False,
                                 env={"PATH": f"{place / 'bin'}:{os.environ['PATH']}"})
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.assertEqual(ran.stdout.splitlines(),
                         ["test: 1 skipped, left to cmake/release_check.sh: packages and wheel in fresh systems, CUDA "
                          "in them, equal bytes, arm64, other compilers, kernels for every GPU",
                          "test: 2 skipped, no Chromium here (package chromium)",
                          "test: 1 skipped, no doxygen here (package doxygen)",
                          "1 passed, 0 failed, 4 skipped"])


if __name__ == "__main__":
    unittest.main()
