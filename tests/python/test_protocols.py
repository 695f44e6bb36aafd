# SPDX-License-Identifier: Apache-2.0
"""Streams and lifetimes of arrays on a device, without one.

Arrays say that they lie on a device and lie on the host, a renderer of the host says that it draws there, and what the
package asks of streams is written down. Tests of real libraries and devices are in the files beside this one.
"""
import collections
import ctypes
import functools
import gc
import sys
import types
import weakref

import numpy as np
import pytest

import swiftgs
from conftest import HEIGHT, OF_GAUSSIANS, WIDTH, arrays_of
from swiftgs import _c, _dlpack, _gsplat
from swiftgs._c import lib


Place = collections.namedtuple("Place", "type index")


class Array:
    """An array of CuPy, as far as the package knows."""

    __module__ = "cupy"

    def __init__(self, array, asked):
        self.array, self.asked = np.array(array, np.float32), asked

    shape = property(lambda self: self.array.shape)
    data = property(lambda self: types.SimpleNamespace(ptr=self.array.ctypes.data))

    def __dlpack_device__(self):
        return _dlpack.CUDA, 0

    def __dlpack__(self, stream=None):
        self.asked.append(stream)
        return self.array.__dlpack__()

    def __mul__(self, other):
        return Array(self.array * other.array, self.asked)

    def view(self, array):
        """Another array, in memory of this one's."""
        found = Array([], self.asked)
        found.array = array
        return found

    def reshape(self, shape):
        return self.view(self.array.reshape(shape))


class Tensor(Array):
    """One of PyTorch, which tells of itself by members."""

    __module__ = "torch"
    requires_grad, dtype, device, layout = False, "torch.float32", Place("cuda", 0), "strided"

    def data_ptr(self):
        return self.array.ctypes.data

    def stride(self):
        return tuple(step // 4 for step in self.array.strides)


class ArrayOfJax(Array):
    __module__ = "jaxlib.xla_extension"


class Bare:
    """An array of a library that is not known, with the older interface."""

    def __init__(self, array, stream=None):
        self.array, self.stream = np.array(array, np.float32), stream

    shape = property(lambda self: self.array.shape)

    @property
    def __cuda_array_interface__(self):
        return dict(self.array.__array_interface__, version=3, stream=self.stream)


class Pretended:
    """What was asked of the device, in order."""

    def __init__(self, monkeypatch):
        self.calls, self.asked, self.memory, self.device, self.stream = [], [], {}, 0, 0
        set_gaussians, borrow_gaussians = lib.renderer_set_gaussians, lib.renderer_borrow_gaussians
        render_into, wait = lib.renderer_render_into, lib.renderer_wait

        def current(device):
            device._obj.value = self.device

        def allocate(count, memory):
            buffer = ctypes.create_string_buffer(count)
            memory._obj.value = ctypes.addressof(buffer)
            self.memory[memory._obj.value] = buffer

        def copy(to, from_, count, stream):
            self.calls.append(("copy", stream))
            ctypes.memmove(to, from_, count)

        def give(function, renderer, struct):
            on_host = _c.Gaussians.from_buffer_copy(struct._obj)
            if on_host.memory == _c.DEVICE:
                self.calls.append(("gaussians", on_host.stream or 0))
            on_host.memory, on_host.stream = _c.HOST, None
            function(renderer, ctypes.byref(on_host))

        def frame(renderer, struct):
            self.calls.append("frame")
            render_into(renderer, struct)

        def waiting(renderer):
            self.calls.append("wait")
            wait(renderer)

        for name, function in {
                "device_current": current, "device_allocate": allocate, "device_copy": copy,
                "device_free": self.memory.pop,
                "renderer_set_gaussians": functools.partial(give, set_gaussians),
                "renderer_borrow_gaussians": functools.partial(give, borrow_gaussians),
                "renderer_render_into": frame, "renderer_wait": waiting,
                "device_order": lambda before, after: self.calls.append(("order", before or 0, after or 0))}.items():
            monkeypatch.setattr(lib, name, function)

        cupy = types.ModuleType("cupy")
        cupy.cuda = types.SimpleNamespace(get_current_stream=lambda: types.SimpleNamespace(ptr=self.stream))
        cupy.empty = lambda shape, dtype: self.array(np.empty(shape, dtype))
        cupy.ascontiguousarray = lambda array: self.array(np.ascontiguousarray(array.array))
        cupy.concatenate = lambda arrays, axis: self.array(np.concatenate([a.array for a in arrays], axis))
        monkeypatch.setitem(sys.modules, "cupy", cupy)
        of_host = _gsplat._renderer
        monkeypatch.setattr(_gsplat, "_renderer",
                            lambda device: of_host(device) if device is None else self.renderer())

    def array(self, array):
        return Array(array, self.asked)

    def renderer(self, stream=0):
        renderer = swiftgs.Renderer("cpu")
        renderer.on_device, renderer._device, renderer._stream = True, 0, stream
        return renderer

    def arguments(self, arguments, kind=None):
        return dict(arguments, **{name: (kind or self.array)(arguments[name]) for name in OF_GAUSSIANS})


@pytest.fixture
def pretended(monkeypatch):
    return Pretended(monkeypatch)


def test_the_current_stream_waits_for_the_renderer_and_the_other_way_round(pretended, gsplat_arguments):
    plain = swiftgs.rasterization(**gsplat_arguments)
    pretended.stream = 77
    colours, alphas, _ = swiftgs.rasterization(**pretended.arguments(gsplat_arguments))
    assert isinstance(colours, Array) and np.array_equal(colours.array, plain[0])
    assert np.array_equal(alphas.array, plain[1])
    # DLPack calls the default stream 1, and none -1: images are ordered by the frame.
    assert pretended.asked == [-1, -1, 1, 1, 1, 1, 1]
    assert pretended.calls[:3] == [("gaussians", 0), ("order", 77, 0), "frame"]
    assert set(pretended.calls[3:]) == {("order", 0, 77)}  # for what becomes of the images and of the Gaussians


def test_one_stream_needs_no_order(pretended, gsplat_arguments):
    swiftgs.rasterization(**pretended.arguments(gsplat_arguments))
    assert pretended.calls == [("gaussians", 0), "frame"]
    pretended.calls.clear(), pretended.asked.clear()
    pretended.stream = 77
    swiftgs.rasterization(**pretended.arguments(gsplat_arguments), renderer=pretended.renderer(77))
    assert pretended.calls == [("gaussians", 77), "frame"] and pretended.asked == [77] * 5


def test_the_stream_of_pytorch_is_ordered_once_for_all_tensors(pretended, gsplat_arguments, monkeypatch):
    plain = swiftgs.rasterization(**gsplat_arguments)
    torch = types.SimpleNamespace(
        strided=Tensor.layout, float32=Tensor.dtype, is_grad_enabled=lambda: True,
        empty=lambda shape, dtype, device: Tensor(np.zeros(shape), pretended.asked),
        cuda=types.SimpleNamespace(current_stream=lambda device: types.SimpleNamespace(cuda_stream=pretended.stream)))
    monkeypatch.setitem(sys.modules, "torch", torch)
    pretended.stream = 77
    renderer, given = pretended.renderer(), pretended.arguments(gsplat_arguments, lambda a: Tensor(a, pretended.asked))
    before, frame = ("order", 77, 0), [("order", 77, 0), "frame", ("order", 0, 77)]  # the images come after it
    for calls in ([before, ("gaussians", 0), *frame], [before, *frame]):
        pretended.calls.clear()
        images, _, _ = swiftgs.rasterization(**given, renderer=renderer)
        assert np.array_equal(images.array, plain[0]) and pretended.calls == calls and not pretended.asked


def test_arrays_that_lie_as_before_are_borrowed_once_and_drawn_as_they_are(pretended, gsplat_arguments):
    renderer, given = pretended.renderer(), pretended.arguments(gsplat_arguments)

    def draw(arguments):
        pretended.calls.clear()
        found = swiftgs.rasterization(**arguments, renderer=renderer)[0].array
        assert pretended.calls[-1] == "frame"
        return found, pretended.calls[:-1]

    first = draw(given)[0]
    again, calls = draw(given)
    assert np.array_equal(again, first) and not calls
    given["means"].array += np.float32(0.25)
    moved, calls = draw(given)
    wanted = swiftgs.rasterization(**dict(gsplat_arguments, means=given["means"].array))[0]
    assert np.array_equal(moved, wanted) and not np.array_equal(moved, first) and not calls

    borrowed = [("gaussians", 0)]
    elsewhere = dict(given, means=pretended.array(gsplat_arguments["means"]))
    assert np.array_equal(draw(elsewhere)[0], first) and pretended.calls == [*borrowed, "frame"]
    fewer = dict(given, **{name: given[name].view(given[name].array[:1000]) for name in OF_GAUSSIANS})
    assert not np.array_equal(draw(given)[0], draw(fewer)[0]) and pretended.calls == [*borrowed, "frame"]
    assert not np.array_equal(draw(dict(fewer, sh_degree=0))[0], draw(fewer)[0])
    degree = np.array(0)
    low = draw(dict(elsewhere, sh_degree=degree))[0]
    degree[...] = 3  # the same object with another value
    assert np.array_equal(draw(dict(elsewhere, sh_degree=degree))[0], first) and not np.array_equal(low, first)
    fortran = dict(given, means=given["means"].view(np.asfortranarray(gsplat_arguments["means"])))
    for _ in range(2):  # is copied each time
        assert np.array_equal(draw(fortran)[0], first) and pretended.calls == [*borrowed, "frame"]


@pytest.mark.parametrize("change", [
    lambda renderer, scene: renderer.set_scene(scene), lambda renderer, scene: renderer.add_scene(scene),
    lambda renderer, scene: renderer.place([swiftgs.Placement(count=100)]),
    lambda renderer, scene: renderer.share_scene(swiftgs.Renderer("cpu", scene=scene)),
    lambda renderer, scene: renderer.set_gaussians(**arrays_of(scene, slice(100)))])
def test_what_else_is_shown_ends_a_borrowing(change, pretended, gsplat_arguments):
    renderer, given = pretended.renderer(), pretended.arguments(gsplat_arguments)
    first = swiftgs.rasterization(**given, renderer=renderer)[0].array
    change(renderer, swiftgs.Scene.builtin(500))
    pretended.calls.clear()
    assert np.array_equal(swiftgs.rasterization(**given, renderer=renderer)[0].array, first)
    assert pretended.calls == [("gaussians", 0), "frame"]


def test_batches_of_other_worlds_are_placed_again(pretended, gsplat_arguments):
    renderer, given = pretended.renderer(), pretended.arguments(gsplat_arguments)
    alone = swiftgs.rasterization(**given, renderer=renderer)[0].array
    halves = {name: given[name].reshape((2, 1000, *given[name].shape[1:])) for name in OF_GAUSSIANS}
    halves.update({name: np.stack([given[name]] * 2) for name in ("viewmats", "Ks")})
    for _ in range(2):
        found = swiftgs.rasterization(**dict(given, **halves), renderer=renderer)[0].array
        for world, part in enumerate((slice(1000), slice(1000, 2000))):
            arguments = {name: gsplat_arguments[name][part] for name in OF_GAUSSIANS}
            assert np.array_equal(found[world], swiftgs.rasterization(**dict(gsplat_arguments, **arguments))[0])
        assert np.array_equal(swiftgs.rasterization(**given, renderer=renderer)[0].array, alone)


def test_neither_images_nor_arrays_are_kept_from_one_call_to_the_next(pretended, gsplat_arguments):
    given, renderer = pretended.arguments(gsplat_arguments), pretended.renderer()
    swiftgs.rasterization(**given, renderer=renderer)
    images, alphas, _ = swiftgs.rasterization(**given, renderer=renderer)
    before, first = images.array.copy(), weakref.ref(given["means"])
    given["means"] = given["means"].view(given["means"].array)
    again, alphas_again, _ = swiftgs.rasterization(**given, renderer=renderer)
    assert again is not images and np.array_equal(images.array, before) and np.array_equal(again.array, before)
    assert first() is None  # another array of the same memory takes its place
    gone = [weakref.ref(array) for array in (images, alphas, again, alphas_again)]
    del images, alphas, again, alphas_again
    assert not any(each() for each in gone)


def test_planes_are_joined_by_their_library_and_matrices_come_to_the_host(pretended, gsplat_arguments):
    plain = {mode: swiftgs.rasterization(**gsplat_arguments, render_mode=mode)[0] for mode in ("D", "RGB+ED")}
    given = pretended.arguments(gsplat_arguments)
    given.update(viewmats=pretended.array(given["viewmats"]), Ks=pretended.array(given["Ks"]))
    for mode, wanted in plain.items():
        pretended.calls.clear()
        images, _, _ = swiftgs.rasterization(**given, render_mode=mode)
        assert isinstance(images, Array) and np.array_equal(images.array, wanted)
        assert pretended.calls == [("copy", 0), ("copy", 0), ("gaussians", 0), "frame"]


def test_orders_and_broadcasts_are_copied_by_their_library(pretended, gsplat_arguments):
    plain = swiftgs.rasterization(**gsplat_arguments)
    given = pretended.arguments(gsplat_arguments)
    given["means"].array = np.asfortranarray(given["means"].array)
    assert np.array_equal(swiftgs.rasterization(**given)[0].array, plain[0])


def test_libraries_that_are_not_known_get_arrays_of_the_package(pretended, gsplat_arguments):
    plain = swiftgs.rasterization(**gsplat_arguments)
    given = pretended.arguments(gsplat_arguments, lambda array: Bare(array, 5))
    images, alphas, _ = swiftgs.rasterization(**given)
    assert pretended.calls == [("order", 5, 0)] * 5 + [("gaussians", 0), "frame", "wait"]
    assert isinstance(images, swiftgs.DeviceArray) and images.shape == (1, HEIGHT, WIDTH, 3)
    assert np.array_equal(images.numpy(), plain[0]) and np.array_equal(np.asarray(alphas), plain[1])
    with pytest.raises(NotImplementedError, match="render_mode is 'RGB.ED', expected 'RGB' or 'ED' for arrays of"):
        swiftgs.rasterization(**given, render_mode="RGB+ED")


def test_arrays_that_are_drawn_where_they_lie_are_kept_until_another_scene(pretended, gsplat_arguments, scene):
    renderer, given = pretended.renderer(), pretended.arguments(gsplat_arguments)
    kept = weakref.ref(given["means"])
    with pytest.raises(swiftgs.InvalidArgument):
        swiftgs.rasterization(**given, renderer=renderer, radial_coeffs=[[np.inf, 0, 0, 0, 0, 0]])
    del given
    assert kept() is not None
    pretended.stream = 77
    pretended.calls.clear()
    renderer.set_scene(scene)
    assert kept() is None and pretended.calls == [("order", 0, 77)]  # the memory may be taken after the frames

    given = pretended.arguments(gsplat_arguments)
    own = weakref.ref(given["means"])
    swiftgs.rasterization(**given)
    del given
    assert own() is None


def test_a_batch_of_arrays_that_are_not_reshaped_is_refused(pretended, gsplat_arguments):
    given = pretended.arguments(gsplat_arguments, lambda array: Bare(array[None], 5))
    given.update(viewmats=gsplat_arguments["viewmats"][None], Ks=gsplat_arguments["Ks"][None])
    with pytest.raises(NotImplementedError, match="means has a batch of .1,., expected none of arrays of"):
        swiftgs.rasterization(**given)


def test_an_array_of_the_package_orders_whoever_takes_it(pretended):
    array = swiftgs.DeviceArray((2, 3))
    array.stream = 4
    assert array.__dlpack_device__() == (_dlpack.CUDA, 0) and array.dtype == np.float32
    interface = array.__cuda_array_interface__
    assert (interface["shape"], interface["typestr"], interface["stream"]) == ((2, 3), "<f4", 4)
    for asked, order in ((None, 1), (1, 1), (2, 2), (9, 9)):
        pretended.calls.clear()
        array.__dlpack__(stream=asked, max_version=(1, 0), dl_device=(_dlpack.CUDA, 0), copy=None)
        assert pretended.calls == [("order", 4, order)]
    pretended.calls.clear()
    capsule = array.__dlpack__(stream=-1)
    assert not pretended.calls and _dlpack.read(capsule)[1:4] == ((2, 3), (12, 4), "f4")
    with pytest.raises(ValueError, match="stream is 0"):
        array.__dlpack__(stream=0)
    for refused in ({"dl_device": (_dlpack.CPU, 0)}, {"copy": True}):
        with pytest.raises(BufferError, match="neither another device nor a copy"):
            array.__dlpack__(**refused)
    assert array.__array__().shape == (2, 3) and array.__array__(np.float64, copy=True).dtype == np.float64
    with pytest.raises(ValueError, match="as a copy only"):  # NumPy 2 asks so for asarray(copy=False)
        array.__array__(copy=False)
    assert len(pretended.memory) == 1
    del array
    gc.collect()
    assert len(pretended.memory) == 1  # the capsule holds it
    del capsule
    gc.collect()
    assert not pretended.memory


def test_arrays_of_jax_come_back_as_arrays_of_jax(pretended, gsplat_arguments, monkeypatch):
    plain = swiftgs.rasterization(**gsplat_arguments)

    def from_dlpack(array):
        array.__dlpack__(stream=12)
        return ArrayOfJax(array.numpy(), [])

    monkeypatch.setitem(sys.modules, "jax", types.ModuleType("jax"))
    monkeypatch.setitem(sys.modules, "jax.dlpack", types.SimpleNamespace(from_dlpack=from_dlpack))
    given = pretended.arguments(gsplat_arguments, lambda array: ArrayOfJax(array, pretended.asked))
    images, _, _ = swiftgs.rasterization(**given)
    assert isinstance(images, ArrayOfJax) and np.array_equal(images.array, plain[0])
    assert pretended.calls[:3] == [("gaussians", 0), "frame", "wait"] and ("order", 0, 12) in pretended.calls
    with pytest.raises(TypeError, match="colour is an array of JAX, which cannot be written to"):
        swiftgs.Frame(given["means"])


def test_frames_of_several_libraries_order_each(pretended, scene, camera, expected):
    renderer = pretended.renderer()
    renderer.set_scene(scene)
    pretended.stream = 77
    colour, depth = pretended.array(np.zeros((HEIGHT, WIDTH, 3))), swiftgs.DeviceArray((HEIGHT, WIDTH))
    frame = swiftgs.Frame(colour, depth=depth)
    pretended.calls.clear()
    renderer.render(camera, out=frame)
    assert pretended.calls == [("order", 77, 0), "frame", ("order", 0, 77)]
    assert np.array_equal(colour.array, expected.colour) and np.array_equal(depth.numpy(), expected.depth)
    assert "CUDA device 0" in repr(frame) and "CUDA device 0" in repr(depth)
    with pytest.raises(ValueError, match="the frame lies on CUDA device 0, expected the host for 'cpu/"):
        swiftgs.Renderer("cpu", scene=scene).render(camera, out=frame)
    with pytest.raises(ValueError, match="alpha lies on the host, expected all planes on one"):
        swiftgs.Frame(colour, np.zeros((HEIGHT, WIDTH), np.float32))


def test_frames_of_unknown_libraries_are_ready_and_finished(pretended, scene, camera, expected):
    renderer = pretended.renderer()
    renderer.set_scene(scene)
    colour = Bare(np.zeros((HEIGHT, WIDTH, 3)), 5)
    frame = swiftgs.Frame(colour)
    assert not pretended.calls
    renderer.render(camera, out=frame)
    assert pretended.calls == [("order", 5, 0), "frame", "wait"] and np.array_equal(colour.array, expected.colour)


def test_other_devices_are_refused(pretended, gsplat_arguments, scene, camera):
    given, renderer = pretended.arguments(gsplat_arguments), pretended.renderer()
    renderer.set_scene(scene)
    frame = swiftgs.Frame(pretended.array(np.zeros((HEIGHT, WIDTH, 3))))
    pretended.device = 1
    with pytest.raises(ValueError, match="means lies on CUDA device 0 and device 1 is current, expected it on the"):
        swiftgs.rasterization(**given)
    with pytest.raises(ValueError, match="CUDA device 1 is current, expected 0, the renderer's"):
        renderer.render(camera, out=frame)
    with pytest.raises(ValueError, match="colour lies on CUDA device 0 and device 1 is current"):
        swiftgs.Frame(pretended.array(np.zeros((HEIGHT, WIDTH, 3))))
    pretended.device = 0
    with pytest.raises(ValueError, match="scales lies on the host and means on CUDA device 0, expected all on one"):
        swiftgs.rasterization(**dict(given, scales=gsplat_arguments["scales"]))
    with pytest.raises(ValueError, match="means lies on CUDA device 0, expected the memory of the renderer 'cpu/"):
        swiftgs.rasterization(**given, renderer=swiftgs.Renderer("cpu"))


def test_streams_of_every_library_are_understood():
    of = types.SimpleNamespace
    for stream, handle in ((None, 0), (7, 7), (of(cuda_stream=8), 8), (of(ptr=9), 9),
                           (of(__cuda_stream__=lambda: (0, 10)), 10)):
        assert swiftgs._arrays.stream_handle(stream) == handle
