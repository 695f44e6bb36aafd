# SPDX-License-Identifier: Apache-2.0
"""Builds what `rivals.py` compares with: 3 minutes on 16 cores.

    SWIFTGS_GSPLAT=FOLDER SWIFTGS_FASTER_GS=FOLDER python3 benchmarks/build_rivals.py

The folders hold the sources of gsplat and of Faster-GS, which is left out without its folder. They are copied into
build/rivals, or where SWIFTGS_RIVALS says, and built there for this machine's GPU: of gsplat 3DGS in 1 to 4 channels
and HiGS, its path for inference. PyTorch with CUDA, ninja and nvcc are needed. GLM, a submodule of gsplat, is that of
SWIFTGS_PREFIX or of the system where the submodule is empty.
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
# Apart from BUILT, where Python would take the folder for the package that it contains.
FASTER_GS = BUILT / "faster-gs/FasterGSCudaBackend"
# Where Python finds what was built.
PLACES = [str(BUILT), str(BUILT / "extensions/gsplat_scene_cuda"), str(FASTER_GS)]

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

# What Faster-GS uses of CUB and CUDA 13 has no longer; nvcc includes it in each source.
MAXIMUM = """
#if __CUDACC_VER_MAJOR__ >= 13
namespace cub {
struct Max {
  template <typename T>
  __host__ __device__ T operator()(T a, T b) const { return a < b ? b : a; }
};
}
#endif
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


def folder_of(variable, project, part):
    source = pathlib.Path(os.environ.get(variable, "/nowhere"))
    if not (source / part).is_dir():
        raise SystemExit(f"{variable} is '{source}', expected a folder with the sources of {project}")
    return source


def copy_gsplat():
    shutil.copytree(folder_of("SWIFTGS_GSPLAT", "gsplat", "gsplat/cuda"), BUILT, dirs_exist_ok=True,
                    ignore=shutil.ignore_patterns(".git", "build", "examples", "docs", "assets", "tests"))
    glm = BUILT / "gsplat/cuda/csrc/third_party/glm"
    if not (glm / "glm/glm.hpp").exists():
        shutil.copytree(find_glm(), glm / "glm", dirs_exist_ok=True)
    if importlib.util.find_spec("rich") is None:
        (BUILT / "rich").mkdir(exist_ok=True)
        (BUILT / "rich/__init__.py").write_text("")
        (BUILT / "rich/console.py").write_text(STUB_OF_RICH)


def copy_faster_gs():
    source = folder_of("SWIFTGS_FASTER_GS", "Faster-GS", FASTER_GS.name)
    shutil.copytree(source / FASTER_GS.name, FASTER_GS, dirs_exist_ok=True)
    (FASTER_GS / "maximum.h").write_text(MAXIMUM)


def main():
    copy_gsplat()
    faster_gs = bool(os.environ.get("SWIFTGS_FASTER_GS"))
    if faster_gs:
        copy_faster_gs()
    else:
        print("Faster-GS is left out: SWIFTGS_FASTER_GS names no folder with its sources", flush=True)
    import torch  # pylint: disable=import-outside-toplevel
    kind = ".".join(map(str, torch.cuda.get_device_capability())) if torch.cuda.is_available() else "9.0"
    environment = {"TORCH_CUDA_ARCH_LIST": kind, "MAX_JOBS": str(os.cpu_count()), **LEAN, **os.environ,
                   "TORCH_EXTENSIONS_DIR": str(BUILT / "extensions")}
    begun = time.monotonic()
    commands = {"gsplat": ["-c", EXTENSION, "0"], "HiGS": ["-c", EXTENSION, "1"],
                "what packs scenes for HiGS": ["-c", PACKING]}
    running = {name: subprocess.Popen([sys.executable, *command], cwd=BUILT, env=environment)
               for name, command in commands.items()}
    if faster_gs:
        running["Faster-GS"] = subprocess.Popen(
            [sys.executable, "setup.py", "build_ext", "--inplace"], cwd=FASTER_GS,
            env={**environment, "NVCC_APPEND_FLAGS": f"-include {FASTER_GS / 'maximum.h'}"})
    failed = [name for name, process in running.items() if process.wait() != 0]
    if failed:
        raise SystemExit(f"not built: {', '.join(failed)}")
    print(f"built in {BUILT} within {time.monotonic() - begun:.0f} s")


if __name__ == "__main__":
    main()
