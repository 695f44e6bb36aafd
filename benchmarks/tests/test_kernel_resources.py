# SPDX-License-Identifier: Apache-2.0
"""kernel_resources.py reads what ptxas says, and names kernels that spill more than before."""
import json
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))
sys.dont_write_bytecode = True

import kernel_resources  # noqa: E402

REPORT = """ptxas info    : 0 bytes gmem
ptxas info    : Compiling entry function '_Z5firstv' for 'sm_90'
ptxas info    : Function properties for _Z5firstv
    0 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads
ptxas info    : Used 32 registers, used 1 barriers
ptxas info    : Function properties for not_a_kernel
    16 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads
ptxas info    : Compiling entry function '_Z6secondv' for 'sm_90'
ptxas info    : Function properties for _Z6secondv
    8 bytes stack frame, 12 bytes spill stores, 16 bytes spill loads
ptxas info    : Used 168 registers, used 0 barriers, 4096 bytes smem
"""


class KernelResources(unittest.TestCase):
    def test_kernels_registers_and_spills_are_read(self):
        self.assertEqual(list(kernel_resources.parse(REPORT)), [("_Z5firstv", 32, 0), ("_Z6secondv", 168, 12)])

    def test_names_lose_what_all_have(self):
        names = ["_ZN7swiftgs7kernels6raster", "void swiftgs::kernels::sort<unsigned int, f(int)>(int, float*)"]
        self.assertEqual(list(kernel_resources.readable(names)), [names[0], "sort<unsigned int, f(int)>"])

    def test_a_kernel_that_spills_more_is_named(self):
        key, other = ("a.cu", "k", 90), ("a.cu", "new", 90)
        before = {key: (100, 8)}
        self.assertEqual(kernel_resources.regressions(before, {key: (120, 8), other: (255, 0)}), [])
        self.assertEqual(kernel_resources.regressions(before, {("a.cu", "k", 120): (9, 4)}), [])  # not measured before
        self.assertEqual(kernel_resources.regressions(before, {key: (100, 12), other: (9, 4)}),
                         ["a.cu: k spills 12 bytes on sm_90, expected at most 8",
                          "a.cu: new spills 4 bytes on sm_90, expected at most 0"])

    def test_each_architecture_of_a_build_is_compiled_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            build = pathlib.Path(folder)
            command = ("ccache /opt/nvcc -O3 --generate-code=arch=compute_75,code=[sm_75] "
                       "--generate-code=arch=compute_90,code=[compute_90,sm_90] -x cu -c /s/backends/cuda/a.cu -o a.o")
            entries = [{"file": "/s/backends/cuda/a.cu", "command": command},
                       {"file": "/s/backends/cpu/a.cpp", "command": "c++ -c a.cpp"}]
            (build / "compile_commands.json").write_text(json.dumps(entries), encoding="utf-8")
            found = list(kernel_resources.commands(build, ()))
        self.assertEqual([(file, architecture) for file, architecture, _ in found], [("a.cu", 75), ("a.cu", 90)])
        self.assertEqual(found[0][2][:7], ["/opt/nvcc", "-O3", "-x", "cu", "/s/backends/cuda/a.cu", "-cubin",
                                           "-arch=sm_75"])

    def test_a_table_is_read_as_it_was_written(self):
        rows = {("a.cu", "k<1, 2>", 75): (40, 0), ("a.cu", "k<1, 2>", 120): (64, 12), ("b.cu", "k", 120): (8, 0)}
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "table.csv"
            kernel_resources.write(table, rows)
            self.assertEqual(table.read_text(encoding="utf-8"),
                             'file,kernel,75,120\na.cu,"k<1, 2>",40,64+12\nb.cu,k,,8\n')
            self.assertEqual(kernel_resources.read(table), rows)

    def test_every_file_of_kernels_is_in_the_recorded_table(self):
        rows = kernel_resources.read(ROOT / "tests/cuda/kernel_resources.csv")
        files = {path.name for path in (ROOT / "backends/cuda").glob("*.cu")}
        self.assertEqual({file for file, _, architecture in rows if architecture == 90}, files)


if __name__ == "__main__":
    unittest.main()
