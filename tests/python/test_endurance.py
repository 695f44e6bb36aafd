# SPDX-License-Identifier: Apache-2.0
"""Many frames: nothing leaks."""
import gc
import pathlib

import numpy as np

import swiftgs
from swiftgs import _dlpack


def resident():
    """Bytes of the process in memory."""
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * 4096


def growth(work, times):
    """Bytes that `times` calls leave behind, after as many that warm up."""
    for _ in range(times // 10):
        work()
    gc.collect()
    before = resident()
    for _ in range(times):
        work()
    gc.collect()
    return resident() - before


def test_ten_thousand_frames_leave_nothing_behind():
    camera = swiftgs.Camera.builtin(32, 24)
    renderer = swiftgs.Renderer("serial", scene=swiftgs.Scene.builtin(50))
    out = swiftgs.Frame.empty(32, 24, alpha=True)
    assert growth(lambda: renderer.render(camera, out=out), 10_000) < 1 << 20
    assert growth(lambda: renderer.render(camera, depth=True, format="rgba8"), 10_000) < 1 << 20
    assert growth(lambda: renderer.render([camera, camera]), 2_000) < 1 << 20


def test_scenes_renderers_and_errors_leave_nothing_behind():
    camera = swiftgs.Camera.builtin(32, 24)
    scene = swiftgs.Scene.builtin(500)
    arrays = (scene.means, scene.scales, scene.rotations, scene.opacities, scene.sh0, scene.sh_rest)
    arguments = (scene.means, scene.rotations, scene.scales, scene.opacities, scene.sh, camera.viewmat[None],
                 camera.K[None], 32, 24)

    def work():
        with swiftgs.Scene.from_arrays(*arrays) as mine, swiftgs.Renderer("serial", scene=mine) as renderer:
            renderer.render(camera)
            assert mine.means.shape == (500, 3)
        try:
            swiftgs.Camera(0, 0, 0)
        except ValueError:
            pass

    assert growth(work, 300) < 4 << 20
    assert growth(lambda: swiftgs.rasterization(*arguments, sh_degree=3), 500) < 4 << 20


def test_capsules_are_given_back_whether_or_not_they_were_taken():
    memory = np.arange(6, dtype=np.float32)
    address = memory.ctypes.data
    capsule = _dlpack.offer(memory, address, (2, 3), 0)
    found = _dlpack.read(capsule)
    assert found == (address, (2, 3), (12, 4), "f4", _dlpack.CUDA, 0) and len(_dlpack._offered) == 1
    del capsule
    gc.collect()
    assert not _dlpack._offered
    taken = _dlpack.offer(memory, address, (6,), 0)
    managed = _dlpack._Managed.from_address(_dlpack._pointer_of(taken, b"dltensor"))
    place = _dlpack._pointer_of(taken, b"dltensor")
    delete = _dlpack.ctypes.CFUNCTYPE(None, _dlpack.c_void_p)(managed.deleter)
    rename = _dlpack._python_function("PyCapsule_SetName", _dlpack.ctypes.c_int, _dlpack.ctypes.py_object,
                                      _dlpack.ctypes.c_char_p)
    used = b"used_dltensor"
    rename(taken, used)  # as a consumer does
    del taken
    assert len(_dlpack._offered) == 1
    delete(place)
    assert not _dlpack._offered
    assert growth(lambda: _dlpack.offer(memory, address, (2, 3), 0), 10_000) < 1 << 20
