# SPDX-License-Identifier: Apache-2.0
"""Many frames: nothing leaks."""
import ctypes
import gc
import pathlib
import sys
import weakref

import numpy as np
import pytest

import swiftgs
from conftest import arrays_of, side_by_side
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
    arrays = arrays_of(scene)
    arguments = (scene.means, scene.rotations, scene.scales, scene.opacities, scene.sh, camera.viewmat[None],
                 camera.K[None], 32, 24)

    def work():
        with swiftgs.Scene.from_arrays(**arrays) as mine, swiftgs.Renderer("serial", scene=mine) as renderer:
            renderer.render(camera)
            assert mine.means.shape == (500, 3)
        try:
            swiftgs.Camera(0, 0, 0)
        except ValueError:
            pass

    assert growth(work, 300) < 4 << 20
    assert growth(lambda: swiftgs.rasterization(*arguments, sh_degree=3), 500) < 4 << 20


class Owner:
    """Memory of a device, as far as a capsule knows."""

    def __init__(self):
        self.memory = np.arange(6, dtype=np.float32)
        self.address = self.memory.ctypes.data

    def __dlpack__(self, **_):
        return _dlpack.offer(self, self.address, (2, 3), 5)

    def __dlpack_device__(self):
        return _dlpack.CUDA, 5


def test_capsules_are_given_back_whether_or_not_they_were_taken():
    owner = Owner()
    gone, address, capsule = weakref.ref(owner), owner.address, owner.__dlpack__()
    assert _dlpack.read(capsule) == (address, (2, 3), (12, 4), "f4", _dlpack.CUDA, 5)
    del owner
    gc.collect()
    assert gone()
    del capsule
    assert gone() is None
    owner = Owner()
    gone, taken = weakref.ref(owner), owner.__dlpack__()
    place = _dlpack._pointer_of(taken, b"dltensor")
    delete = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(_dlpack._Managed.from_address(place).deleter)
    used = b"used_dltensor"
    rename = ctypes.pythonapi.PyCapsule_SetName
    assert rename(ctypes.py_object(taken), used) == 0  # as a consumer does
    del taken, owner
    gc.collect()
    assert gone()
    side_by_side(lambda: delete(place))
    assert gone() is None
    owner = Owner()
    assert growth(owner.__dlpack__, 10_000) < 1 << 20


def test_a_consumer_that_refuses_a_capsule_keeps_its_exception():
    owner = Owner()
    before = sys.getrefcount(owner)
    for _ in range(3):
        with pytest.raises((RuntimeError, BufferError), match="[Uu]nsupported device"):
            np.from_dlpack(owner)
    gc.collect()
    assert sys.getrefcount(owner) == before
