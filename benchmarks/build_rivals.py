# SPDX-License-Identifier: Apache-2.0
"""Builds gsplat and HiGS, its path for inference, for `beside_gsplat.py` and `rivals.py`: 3 minutes on 16 cores.

    SWIFTGS_GSPLAT=FOLDER python3 benchmarks/build_rivals.py

The folder holds gsplat's sources. They are copied into build/rivals, or where SWIFTGS_RIVALS says, and 3DGS in 1 to 4
channels and HiGS are built there for this machine's GPU. PyTorch with CUDA, ninja and nvcc are needed. GLM, a submodule
of gsplat, is that of SWIFTGS_PREFIX or of the system where the submodule is empty.
"""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
BUILT = pathlib.Path(os.environ.get("SWIFTGS_RIVALS", ROOT / "build/rivals")).resolve()
# Where Python finds what was built.
PLACES = [str(BUILT), str(BUILT / "extensions/gsplat_scene_cuda")]

# What a comparison does not need is left out, since it takes most of the time of a build.
LEAN = {"BUILD_2DGS": "0", "BUILD_3DGUT": "0", "BUILD_ADAM": "0", "BUILD_RELOC": "0", "BUILD_LOSSES": "0",
        "NUM_CHANNELS": "1,2,3,4"}

# One of the two extensions of gsplat's setup.py, so that they are built at once: 3DGS, HiGS.
EXTENSION = """
import setup, setuptools, sys
setuptools.setup(name="gsplat", packages=["gsplat"], ext_modules=[setup.get_extensions()[int(sys.argv[1])]],
                 cmdclass={"build_ext": setup.get_ext()},
                 script_args=["build_ext", "--inplace", "--build-temp", "build/" + sys.argv[1]])
"""
# Packs scenes for HiGS; gsplat builds it at its first use otherwise.
PACKING = """
import importlib.util
spec = importlib.util.spec_from_file_location("packing", "gsplat/scene/kernels/cuda/build.py")
packing = importlib.util.module_from_spec(spec)
spec.loader.exec_module(packing)
packing.build_and_load_scene_cuda()
"""

STUB_OF_RICH = '''class Console:
    """What gsplat prints its notes by, where rich is not installed."""

    print = staticmethod(print)

    def status(self, *_, **__):
        import contextlib
        return contextlib.nullcontext()
'''


def find_glm():
    places = [os.environ.get("SWIFTGS_PREFIX", "/nowhere") + "/usr/include", "/usr/include", "/usr/local/include"]
    for place in map(pathlib.Path, places):
        if (place / "glm/glm.hpp").exists():
            return place / "glm"
    raise SystemExit(f"GLM: expected glm/glm.hpp in one of {', '.join(places)}")


def copy_gsplat():
    source = os.environ.get("SWIFTGS_GSPLAT")
    if not source or not (pathlib.Path(source) / "gsplat/cuda").is_dir():
        raise SystemExit(f"SWIFTGS_GSPLAT is '{source}', expected a folder with the sources of gsplat")
    shutil.copytree(source, BUILT, dirs_exist_ok=True,
                    ignore=shutil.ignore_patterns(".git", "build", "examples", "docs", "assets", "tests"))
    glm = BUILT / "gsplat/cuda/csrc/third_party/glm"
    if not (glm / "glm/glm.hpp").exists():
        shutil.copytree(find_glm(), glm / "glm", dirs_exist_ok=True)
    if importlib.util.find_spec("rich") is None:
        (BUILT / "rich").mkdir(exist_ok=True)
        (BUILT / "rich/__init__.py").write_text("")
        (BUILT / "rich/console.py").write_text(STUB_OF_RICH)


def main():
    copy_gsplat()
    import torch  # pylint: disable=import-outside-toplevel
    kind = ".".join(map(str, torch.cuda.get_device_capability())) if torch.cuda.is_available() else "9.0"
    environment = {"TORCH_CUDA_ARCH_LIST": kind, "MAX_JOBS": str(os.cpu_count()), **LEAN, **os.environ,
                   "TORCH_EXTENSIONS_DIR": str(BUILT / "extensions")}
    begun = time.monotonic()
    commands = {"gsplat": [EXTENSION, "0"], "HiGS": [EXTENSION, "1"], "what packs scenes for HiGS": [PACKING]}
    running = {name: subprocess.Popen([sys.executable, "-c", *command], cwd=BUILT, env=environment)
               for name, command in commands.items()}
    failed = [name for name, process in running.items() if process.wait() != 0]
    if failed:
        raise SystemExit(f"not built: {', '.join(failed)}")
    print(f"built in {BUILT} within {time.monotonic() - begun:.0f} s")


if __name__ == "__main__":
    main()
