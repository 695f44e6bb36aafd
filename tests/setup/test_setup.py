# SPDX-License-Identifier: Apache-2.0
"""cmake/setup.sh: fails without what is needed, goes on without what is optional. Presets: kernels suit the machine."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
STUBS = {
    "id": "echo 0",
    "dpkg-query": 'for name; do :; done\ncase " $MISSING " in *" $name "*) exit 1 ;; esac\necho installed',
    "apt-cache": 'case " $UNKNOWN " in *" $2 "*) echo "  Candidate: (none)" ;; *) echo "  Candidate: 1.0" ;; esac',
    "apt-get": 'echo "$*" >>"$CALLS"\nfor broken in $BROKEN; do case " $* " in *" $broken "*) exit 100 ;; esac; done',
}


def packages(part):
    lines = (line.split() for line in (ROOT / "cmake" / "packages.txt").read_text(encoding="utf-8").splitlines())
    return [words[0] for words in lines if len(words) > 1 and words[0] != "#" and words[1] == part]


class Setup(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.place = pathlib.Path(folder.name)
        for name, body in STUBS.items():
            (self.place / name).write_text(f"#!/bin/sh\n{body}\n", encoding="utf-8")
            (self.place / name).chmod(0o755)
        self.needed, self.optional = packages("test")[0], packages("test?")[0]

    def setup_sh(self, missing=(), unknown=(), broken=()):
        """(exit code, standard output, standard error, [arguments of apt-get])"""
        calls = self.place / "calls"
        calls.write_text("", encoding="utf-8")
        ran = subprocess.run([str(ROOT / "cmake" / "setup.sh"), "test"], capture_output=True, text=True, check=False,
                             env={"PATH": f"{self.place}:{os.environ['PATH']}", "CALLS": str(calls),
                                  "MISSING": " ".join(missing), "UNKNOWN": " ".join(unknown),
                                  "BROKEN": " ".join(broken)})
        return ran.returncode, ran.stdout, ran.stderr, calls.read_text(encoding="utf-8").splitlines()

    def test_nothing_is_asked_of_the_network_where_nothing_is_missing(self):
        self.assertEqual(self.setup_sh(), (0, "", "", []))

    def test_what_is_missing_is_installed(self):
        code, _, _, calls = self.setup_sh(missing=(self.needed, self.optional))
        self.assertEqual(code, 0)
        self.assertEqual([call.split()[-1] for call in calls], ["update", self.needed, self.optional])

    def test_without_a_network_what_is_optional_is_one_line_and_all_goes_on(self):
        code, output, error, calls = self.setup_sh(missing=(self.optional,), broken=("update",))
        self.assertEqual((code, error, len(calls)), (0, "", 1))
        self.assertEqual(output, f"setup: apt-get update failed; going on without {self.optional}, which is optional\n")

    def test_what_is_optional_and_cannot_be_installed_is_said_and_keeps_nothing_away(self):
        for missing in ((self.optional,), (self.needed, self.optional)):
            code, output, error, calls = self.setup_sh(missing=missing, broken=(self.optional,))
            self.assertEqual((code, error), (0, ""))
            self.assertEqual([call.split()[-1] for call in calls], ["update", *missing])
            self.assertEqual(output.splitlines()[-1],
                             f"setup: {self.optional} cannot be installed; going on without it, it is optional")

    def test_what_is_optional_and_unknown_costs_no_network(self):
        code, output, _, calls = self.setup_sh(missing=(self.optional,), unknown=(self.optional,))
        self.assertEqual((code, calls), (0, []))
        self.assertEqual(output, f"setup: there is no package {self.optional} here\n")

    def test_a_package_of_many_versions_is_found_a_hundred_times_of_a_hundred(self):
        versions = "echo '  Candidate: 1.0'\nseq -f '     %g-1 500' 30000\n"  # more than a pipe holds
        (self.place / "apt-cache").write_text(f"#!/bin/sh\n{versions}", encoding="utf-8")
        lines = (ROOT / "cmake" / "setup.sh").read_text(encoding="utf-8").splitlines()
        function = [line for line in lines if line.startswith("has_candidate()")]
        self.assertEqual(len(function), 1)
        script = f"set -euo pipefail\n{function[0]}\nfor i in {{1..100}}; do has_candidate {self.optional}; done"
        ran = subprocess.run(["bash", "-c", script], check=False,
                             env={"PATH": f"{self.place}:{os.environ['PATH']}"})
        self.assertEqual(ran.returncode, 0)

    def test_without_what_is_needed_nothing_goes_on(self):
        code, _, error, calls = self.setup_sh(missing=(self.needed, self.optional), broken=("update",))
        self.assertEqual((code, len(calls)), (1, 1))
        self.assertEqual(error, f"setup: apt-get update failed; expected a network to install {self.needed} from\n")
        code, output, _, calls = self.setup_sh(missing=(self.needed, self.optional), broken=(self.needed,))
        self.assertNotEqual(code, 0)
        self.assertNotIn("optional", output)
        self.assertEqual(len(calls), 2)


class NativeGpus(unittest.TestCase):
    def kinds(self, nvidia_smi):
        """The kinds of GPUs where `nvidia_smi` is the program of this name."""
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            script = place / "ask.cmake"
            script.write_text(f'include("{ROOT}/cmake/NativeGpus.cmake")\nswiftgs_native_gpus(kinds)\n'
                              'message("kinds=${kinds}")\n', encoding="utf-8")
            (place / "nvidia-smi").write_text(f"#!/bin/sh\n{nvidia_smi}\n", encoding="utf-8")
            (place / "nvidia-smi").chmod(0o755)
            ran = subprocess.run([shutil.which("cmake"), "-P", str(script)], capture_output=True, text=True, check=True,
                                 env={"PATH": f"{place}:/usr/bin:/bin"})
        return ran.stderr.strip()

    def test_kernels_are_compiled_for_each_kind_of_gpu_here_that_nvcc_knows(self):
        for nvidia_smi, kinds in (("printf '8.9\\n12.0\\n8.9\\n'", "89;120"), ("printf '7.0\\n7.5\\n'", "75"),
                                  ("echo 6.1", ""), ("echo 'NVIDIA-SMI has failed: no driver'; exit 9", ""),
                                  ("echo 'No devices were found'", "")):
            self.assertEqual(self.kinds(nvidia_smi), f"kinds={kinds}", nvidia_smi)

    def test_presets_ask_for_the_gpus_of_the_machine(self):
        presets = json.loads((ROOT / "CMakePresets.json").read_text(encoding="utf-8"))["configurePresets"]
        kinds = {preset["name"]: preset["cacheVariables"]["CMAKE_CUDA_ARCHITECTURES"] for preset in presets
                 if "CMAKE_CUDA_ARCHITECTURES" in preset.get("cacheVariables", {})}
        self.assertEqual(kinds, {"release": "native", "debug": "native"})


if __name__ == "__main__":
    unittest.main()
