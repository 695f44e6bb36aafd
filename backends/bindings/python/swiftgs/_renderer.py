# SPDX-License-Identifier: Apache-2.0
"""Renderers, by name."""
import ctypes
import threading
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _arrays, _c, _checks
from ._c import Handle, count_of, lib, render, text_of
from ._camera import Camera, check_cameras
from ._errors import InvalidArgument, InvalidType, OrderError
from ._frame import Frame
from ._gaussians import Given, gaussians_of
from ._model import RenderingModel
from ._placement import Placement, RecordedScenes
from ._scene import Scene


class RendererEntry(NamedTuple):
    """One row of the table of renderers."""

    name: str  #: BACKEND/SORT/RASTER/BOUNDS
    usable: bool  #: whether it can run on this machine
    on_device: bool  #: whether it draws on a CUDA device


class Statistics(NamedTuple):
    """Counts of a frame. Those from `intersections_visited` on are 0 unless the frame was drawn with `counts=True`."""

    gaussians: int  #: in all placed scenes
    visible: int  #: projected to splats
    intersections: int  #: pairs of splat and tile
    intersections_visited: int  #: before all pixels of their raster block had stopped
    rows_visited: int  #: rows of pixels on which an intersection was evaluated
    contributing_pairs: int  #: pairs of pixel and splat that were blended
    pixels_stopped: int  #: pixels that ended before their list
    #: those of `intersections` at or behind an occluder in all pixels of their tile; nearly all if a depth buffer is
    #: taken for depths themselves, because `stored_depth` is missing
    intersections_hidden: int

    @property
    def nearly_all_hidden(self) -> bool:
        """Whether occluders hide 99 % of the intersections or more: mostly the sign of a missing `stored_depth`."""
        return 0 < self.intersections >= 100 * (self.intersections - self.intersections_hidden)


class Picked(NamedTuple):
    """What a pixel shows. Weights are alpha times transmittance, as axis-shared-threshold-float-cholesky blends with
    them, whatever the renderer; depths are those of the Gaussians' means."""

    #: index of the largest weight, of equal ones the nearest; None: nothing is there. Of several placed scenes
    #: `Renderer.placed_scene_of` tells which.
    gaussian: Optional[int]
    weight: float  #: of that Gaussian
    depth: float
    median: Optional[int]  #: the Gaussian that takes the transmittance below 1/2; None: none does
    median_depth: float


class Times(NamedTuple):
    """Milliseconds of a frame's stages. Not a number unless the frame was drawn with `times=True` and is finished."""

    project: float
    sort: float
    raster: float
    total: float


class Report(NamedTuple):
    """What a recorded frame took. If it overflowed, it drew nothing; a capacity of these numbers suffices."""

    visible: int  #: splats, of all images
    intersections: int  #: pairs of splat and tile
    overflowed: bool  #: they were more than was reserved


class Memory(NamedTuple):
    """Bytes that a renderer keeps, the scene excluded, and those of its device."""

    project: int
    sort: int
    raster: int
    device_in_use: int
    device_total: int


def _members(struct: Any, kind: Any) -> Any:
    return kind(*(getattr(struct, name) for name in kind._fields))


def list_renderers() -> List[RendererEntry]:
    """Every renderer of this build, whether or not it can run here."""
    found = []
    for index in range(count_of(lib.renderers_count)):
        entry = _c.RendererEntry()
        lib.renderers_get(index, ctypes.byref(entry))
        found.append(_entry_of(entry))
    return found


def find_renderer(name: Optional[str] = None) -> RendererEntry:
    """The renderer of that name, the usual one of a backend, or without a name that of the quickest backend that runs
    here. InvalidArgument for any other name."""
    entry = _c.RendererEntry()
    lib.renderers_find(None if name is None else _checks.text(name, "renderer"), ctypes.byref(entry))
    return _entry_of(entry)


def _entry_of(entry: _c.RendererEntry) -> RendererEntry:
    return RendererEntry(entry.name.decode(), bool(entry.usable), bool(entry.on_device))


class Renderer:
    """Draws frames of the scenes that it was given.

    It keeps its memory: a frame no larger than an earlier one allocates nothing. Calls from several threads run one
    after another; a renderer for each thread draws at once with others.

    >>> renderer = Renderer("cpu", scene=Scene.builtin())
    >>> renderer.render(Camera.builtin()).save("frame.png")
    """

    def __init__(self, name: Optional[str] = None, *, scene: Optional[Scene] = None, threads: int = 0,
                 stream: Any = None, harmonics: str = "smallest") -> None:
        """`name` is BACKEND/SORT/RASTER/BOUNDS, as in `list_renderers`, or a backend alone, whose usual choice it then
        is; without one it is that of the quickest backend that runs here.

        `threads` are those of the backend `cpu`, 0 for all. `stream` is that of the backend `cuda`: of PyTorch, of
        CuPy, any object with `__cuda_stream__`, or the number of a cudaStream_t; the default stream without one. The
        renderer belongs to the CUDA device that is current now.

        `harmonics` says how a `Scene` is uploaded: "smallest", in the fewest bytes that hold its harmonics exactly;
        "float", so that `update_scene` may replace them; or "half", rounded. Those of arrays stay floats.
        """
        entry = find_renderer(name)
        self._stream = _arrays.stream_handle(stream)
        options = _c.RendererOptions(threads=threads, stream=self._stream,
                                     harmonics=_checks.choice(harmonics, "harmonics", _c.HARMONICS))
        self._handle: Optional[Handle] = Handle(lib.renderer_free, lib.renderer_create, entry.name.encode(),
                                                ctypes.byref(options), outlived_by=stream)
        self.name = entry.name  #: BACKEND/SORT/RASTER/BOUNDS
        self.on_device = entry.on_device  #: whether it draws on a CUDA device
        self._device = _arrays.current_device() if self.on_device else None
        self._scene_lock = threading.RLock()  # `rasterization` draws before another thread changes the scene
        self._counts: List[int] = []  # Gaussians of each scene
        self._placed: List[range] = []  # Gaussians of each placement, as its scene numbers them
        self._cut: Any = None  # of a pool, which frames show in place of `_placed`
        self._borrowed: Optional[Given] = None  # what frames read where it lies
        self._shown: Any = None  # struct, worlds and addresses of borrowed arrays; None if frames show anything else
        self._last: Tuple[Any, Any] = None, None  # layout and struct of the last arrays of `_draw_gaussians`
        self._recorded: Optional[Frame] = None  # keeps the arrays that recorded frames are drawn into
        self._report: Any = None
        self._has_recorded = False
        if scene is not None:
            self.set_scene(scene)

    @property
    def device_name(self) -> str:
        """Model of the processor or device, with the number of threads where that is a choice."""
        return text_of(lib.renderer_device_name, self._open())

    def set_scene(self, scene: Scene) -> None:
        """Uploads `scene` for the frames that follow, in place of all scenes and placements before; backends of the
        host share its memory."""
        with self._scene_lock:
            self._change(lib.renderer_set_scene, self._open(), self._handle_of(scene))
            self._forget(len(scene))

    def add_scene(self, scene: Scene) -> int:
        """Uploads one more scene, and returns its number: 0, 1 and so on. Frames show it too, where it stands by
        itself, until the next `place`."""
        number = ctypes.c_uint64()
        with self._scene_lock:
            self._change(lib.renderer_add_scene, self._open(), self._handle_of(scene), ctypes.byref(number))
            self._counts.append(len(scene))
            self._placed.append(range(len(scene)))
            self._cut = None
        return number.value

    @staticmethod
    def _handle_of(scene: Scene) -> Handle:
        return _checks.of_type(scene, Scene, "scene", "; swiftgs.load reads one")._open()

    def place(self, placements: Sequence[Placement]) -> None:
        """Sets the placed scenes that frames show: any of the renderer's scenes, any number of times. Gaussians are
        numbered over all of them, those of the first placed scene first: see `placed_scene_of`. If something of
        `placements` is refused, nothing changes."""
        found = _checks.listed(placements, "placements")
        structs: Any = (_c.Placement * len(found))()
        for index, placement in enumerate(found):
            structs[index] = _checks.of_type(placement, Placement, f"placement {index}")._struct()
        with self._scene_lock:
            self._change(lib.renderer_place, self._open(), structs, len(structs))
            ends = (each.first + each.count if each.count else self._counts[each.scene] for each in structs)
            self._placed = [range(each.first, end) for each, end in zip(structs, ends)]
            self._cut = None

    def placed_scene_of(self, numbers: Any) -> Tuple[np.ndarray, np.ndarray]:
        """The placement of each Gaussian that a frame numbers, such as by its plane `id`, and the Gaussian's index in
        that scene: two arrays of the shape of `numbers`, with -1 in both for `NOTHING`. OrderError while pages show:
        `PagePool.named` tells theirs."""
        found = _checks.reals(numbers, "numbers", dtype=None)
        if found.dtype.kind not in "ui":
            raise InvalidType(f"numbers are of type {found.dtype}, expected whole numbers")
        found = found.astype(np.int64)
        with self._scene_lock:
            if self._cut is not None:
                raise OrderError("placed_scene_of: pages show, expected PagePool.named")
            firsts = np.cumsum([0] + [len(shown) for shown in self._placed])
            starts = np.array([shown.start for shown in self._placed] or [0])
        nothing = found == _c.NOTHING
        wrong = ~nothing & ((found < 0) | (found >= firsts[-1]))
        if wrong.any():
            raise InvalidArgument(f"numbers have {found[wrong][0]}, expected less than {firsts[-1]} or NOTHING")
        placement = np.searchsorted(firsts[1:], found, side="right")
        placement = np.where(nothing, 0, placement)
        index = found - firsts[placement] + starts[placement]
        return np.where(nothing, -1, placement), np.where(nothing, -1, index)

    def share_scene(self, other: "Renderer") -> None:
        """Shares the scenes that `other`, a renderer of the same backend, has uploaded, and their placements, but no
        pages."""
        _checks.of_type(other, Renderer, "other")
        first, second = sorted((self, other), key=id)  # two that share with each other must not wait for ever
        with first._scene_lock, second._scene_lock:
            self._change(lib.renderer_share_scene, self._open(), other._open())
            self._give_back()
            self._counts, self._placed, self._cut = list(other._counts), list(other._placed), None
            self._borrowed = other._borrowed

    def set_gaussians(self, means: Any, scales: Any, rotations: Any, opacities: Any, sh0: Any = None,
                      sh_rest: Any = None, *, colours: Any = None, log_scales: bool = False,
                      logit_opacities: bool = False, any_rotations: bool = True, features: Any = None,
                      model: RenderingModel = RenderingModel()) -> None:
        """As `set_scene`, of arrays as `Scene.from_arrays` takes them.

        Arrays of a CUDA device go to a renderer of `cuda` within the device, in the order of their library's stream,
        and nothing waits. They may be changed or forgotten afterwards. There a Gaussian with a NaN or an infinity is
        not drawn; on the host it is refused.
        """
        if (sh0 is None) == (colours is None):
            raise InvalidType("set_gaussians takes either sh0 or colours")
        self._set_gaussians(means, scales, rotations, opacities, sh0, sh_rest, colours=colours, log_scales=log_scales,
                            logit_opacities=logit_opacities, any_rotations=any_rotations, features=features,
                            model=model)

    def _set_gaussians(self, *arrays: Any, **options: Any) -> None:
        with self._scene_lock:
            given = self._read(arrays, options)
            self._give(lib.renderer_set_gaussians, (), given)
            self._forget(given.count)
            self._hand_on_all(given)

    def _draw_gaussians(self, out: Frame, worlds: int, arrays: Sequence[Any], options: Dict[str, Any]) -> None:
        """Draws a frame of as many worlds, which lie one behind another in the arrays, and which of them an image shows
        `out` tells. Those of a device are read where they lie, in each frame until another scene is set."""
        with self._scene_lock:
            given = self._read(arrays, options, self._last)
            self._last = given.layout, given.struct
            shown = given.struct, worlds, [found.address for found in given.memory]
            is_shown = shown == self._shown
            if not is_shown:
                self._give(lib.renderer_borrow_gaussians if self.on_device else lib.renderer_set_gaussians, (), given)
                self._forget(given.count)
            if self.on_device:
                self._borrowed = given
            if worlds > 1 and not is_shown:
                each = given.count // worlds
                self.place([Placement(first=world * each, count=each or None) for world in range(worlds)])
            if self.on_device:
                self._shown = shown
            self._draw(out, given.sources)

    def _change(self, call: Any, *arguments: Any) -> None:
        """Calls a function of the library that may change what frames show, even if it fails."""
        self._shown = None
        call(*arguments)

    def _forget(self, count: int) -> None:
        """The scenes of before: there is one of so many Gaussians."""
        self._counts, self._placed, self._cut = [count], [range(count)], None
        self._give_back()

    def _give_back(self) -> None:
        """Borrowed arrays: what their libraries do next with the memory comes after the frames that read it."""
        if self._borrowed is not None:
            given, self._borrowed = self._borrowed, None
            self._hand_on_all(given)

    def update_scene(self, scene: int = 0, first: int = 0, *, means: Any = None, scales: Any = None,
                     rotations: Any = None, opacities: Any = None, sh0: Any = None, sh_rest: Any = None,
                     colours: Any = None, log_scales: bool = False, logit_opacities: bool = False,
                     any_rotations: bool = True, features: Any = None) -> None:
        """Replaces Gaussians of scene number `scene` from number `first` on by as many as the arrays have; what is None
        stays as it is.

        Arrays are as `Scene.from_arrays` takes them, of the scene's degree and number of features (a device keeps no
        bands of a `Scene` above the highest one with a number other than 0, and replaces harmonics only of renderers
        with `harmonics="float"`). They lie where the renderer draws: on the
        host, or on its CUDA device, where nothing waits. Renderers that share the scene show the update too, and all
        later and recorded frames. On the host none of them may be drawing, and the `Scene` stays as it is. If something
        is refused, nothing changes.
        """
        number = _checks.whole(scene, "update_scene: scene", 0, 2**64)
        start = _checks.whole(first, "update_scene: first", 0, 2**64)
        if sh0 is not None and colours is not None:
            raise InvalidType("update_scene takes either sh0 or colours")
        arrays = (means, scales, rotations, opacities, sh0, sh_rest)
        options = dict(colours=colours, log_scales=log_scales, logit_opacities=logit_opacities,
                       any_rotations=any_rotations, features=features)
        with self._scene_lock:
            given = self._read(arrays, dict(options, some=True))
            self._give(lib.renderer_update_scene, (number, start), given)
            self._hand_on_all(given)

    def _read(self, arrays: Sequence[Any], options: Dict[str, Any], last: Tuple[Any, Any] = (None, None)) -> Given:
        """Arrays for a function of the library. They are ready for the renderer."""
        self._open()
        return gaussians_of(*arrays, stream=self._stream, last=last, **options)

    def _give(self, call: Any, numbers: Tuple[int, ...], given: Given) -> None:
        """Gives arrays to a function of the library."""
        if given.device is not None:
            self._check_device()
        self._change(call, self._open(), *numbers, ctypes.byref(given.struct))

    def _hand_on_all(self, given: Given) -> None:
        """What the libraries of arrays do next with them comes after what the renderer has been given."""
        if given.device is not None:
            for stream in {_arrays.stream_of(array, given.device) for array in given.sources.values()}:
                self._hand_on(self._open(), stream)

    def _hand_on(self, handle: Handle, stream: Optional[int]) -> None:
        """What a library does next on its stream comes after what the renderer has been given."""
        if stream is None:
            lib.renderer_wait(handle)
        elif stream != self._stream:
            lib.device_order(self._stream or None, stream or None)

    def render(self, cameras: Union[Camera, Sequence[Camera]], *, out: Optional[Frame] = None,
               format: str = "rgb",  # pylint: disable=redefined-builtin
               times: bool = False, counts: bool = False, **frame: Any) -> Frame:
        """Draws the view of one camera, or those of several of one size in one frame, each with the bits that it has
        alone.

        Without `out` the images are new arrays of NumPy, whatever the backend: of one image without an index of the
        image, of a sequence of cameras with it. `format` is "rgb", "rgba", "rgba-half" or "rgba8"; `alpha=True`,
        `depth=True` and so on add the planes of `Frame`, `features=3` the first three of the scene's, `colour=False`
        leaves colour out, and `background`, `conventions`, `occluder`, `stored_depth`, `first_pixel`, `conversion` and
        `shows` are those of `Frame`. With `out`, a frame of yours, all of that is the frame's,
        and the same frame comes back.

        Frames on the host are complete when it returns. Those in arrays of a CUDA device are in the order of their
        library's stream. `times` and `counts` fill `self.times` and `self.statistics`.
        """
        if out is None:
            cameras = cameras if isinstance(cameras, Camera) else _checks.listed(cameras, "cameras")
            out = self._new_frame(cameras, format, frame)
        elif frame or format != "rgb":
            raise InvalidType(f"render takes either out or {', '.join(frame) or 'format'}")
        else:
            _checks.of_type(out, Frame, "out")
        # A frame leaves the processor's caches cold, so that each step of Python costs microseconds: this is the way of
        # the usual call.
        if type(cameras) is Camera and cameras._size is out._one_size:
            out._camera_bytes[:] = cameras._bytes
        else:
            out._aim(cameras)
        if times is not out._times or counts is not out._counts:
            out._measure(times, counts)
        self._draw(out)
        return out

    @staticmethod
    def _new_frame(cameras: Union[Camera, Sequence[Camera]], form: str, options: Any) -> Frame:
        found = check_cameras(cameras)
        size = found[0]._size
        for index, camera in enumerate(found):
            if camera._size != size:
                raise InvalidArgument(f"camera {index} has {camera.width}x{camera.height} pixels, expected "
                                      f"{size[0]}x{size[1]}, as the first")
        return Frame.empty(*size, None if isinstance(cameras, Camera) else len(found), format=form, **options)

    def _draw(self, out: Frame, given: Optional[Dict[Any, Any]] = None) -> None:
        """`given`: sources of the arrays that have just been borrowed for it."""
        handle = self._handle or self._open()  # kept until the frame is drawn
        if out.device is not None:
            self._draw_on_device(handle, out, given or {})
            return
        status = render(handle.argument, out._argument)
        if status:
            _c.check(status)

    def _check_on_device(self, out: Frame) -> None:
        if not self.on_device:
            raise InvalidArgument(f"the frame lies on CUDA device {out.device}, expected the host for '{self.name}'")
        self._check_device()
        if out.device != self._device:
            raise InvalidArgument(f"the frame lies on CUDA device {out.device}, expected {self._device}, the "
                                  "renderer's")

    def _draw_on_device(self, handle: Handle, out: Frame, given: Dict[Any, Any]) -> None:
        self._check_on_device(out)
        device, sources = out.device or 0, out._sources
        streams = [_arrays.stream_of(array, device) for array in sources.values()]
        for array, stream in zip(sources.values(), streams):
            if stream is None:
                _arrays.read(array, "the frame", self._stream)  # its protocol makes it ready
            elif stream != self._stream:
                lib.device_order(stream or None, self._stream or None)
        lib.renderer_render_into(handle, out._argument)
        for array, stream in zip(sources.values(), streams):
            if isinstance(array, _arrays.DeviceArray):
                array.stream, array._stream_owner = self._stream, handle.outlived_by
            else:
                self._hand_on(handle, stream)
        for source, array in given.items():
            if source not in sources:
                self._hand_on(handle, _arrays.stream_of(array, device))

    def _check_device(self) -> None:
        if not self.on_device:
            return
        if _arrays.current_device() != self._device:
            raise InvalidArgument(f"CUDA device {_arrays.current_device()} is current, expected {self._device}, the "
                                  "renderer's")

    def reserve(self, cameras: Union[Camera, Sequence[Camera]], out: Frame, *, splats: int = 0,
                intersections: int = 0) -> None:
        """Takes all memory that `record` needs to draw the views of `cameras` into `out`, whose arrays lie where the
        renderer draws. Draws nothing and waits. A capacity of 0 is what there is to see now, and an eighth more."""
        capacity = _c.Capacity(splats=splats, intersections=intersections)
        frame = self._recorded_frame(cameras, out)
        lib.renderer_reserve(self._open(), frame, ctypes.byref(capacity))
        self._recorded = out
        self._report, self._has_recorded = _arrays.DeviceArray((6,)) if self.on_device else _c.Report(), False

    def set_views(self, cameras: Union[Camera, Sequence[Camera]], out: Frame) -> None:
        """Sets the cameras and the arrays of recorded frames, in the order of the renderer's stream: as many images of
        the same size with the same planes as were reserved."""
        self._check_reserved("set_views")
        lib.renderer_set_views(self._open(), self._recorded_frame(cameras, out))
        self._recorded = out

    def _recorded_frame(self, cameras: Union[Camera, Sequence[Camera]], out: Frame) -> Any:
        if _checks.of_type(out, Frame, "out").device is not None:
            self._check_on_device(out)
        elif self.on_device:
            raise InvalidArgument(f"the frame lies on the host, expected CUDA device {self._device}, the renderer's")
        out._aim(cameras)
        out._measure(False, False)
        return out._argument

    def record(self) -> None:
        """Draws what `reserve` and `set_views` were given, without a wait and in the order of the renderer's stream
        alone: what else works on the arrays must be on that stream. A CUDA graph may capture it, such as
        `with torch.cuda.graph(graph, stream=stream): renderer.record()` with `Renderer("cuda", stream=stream)`.
        docs/scenes.md says what may change between replays. Keep the frame as long as the graph."""
        self._check_reserved("record")
        lib.renderer_record(self._open(), ctypes.c_void_p(self._report._memory.pointer) if self.on_device else
                            ctypes.byref(self._report))
        self._has_recorded = True

    def _check_reserved(self, what: str) -> None:
        if self._recorded is None:
            raise OrderError(f"{what}: nothing was reserved, expected Renderer.reserve before")

    @property
    def report(self) -> Report:
        """Of the last recorded frame. Waits."""
        if self._recorded is None or not self._has_recorded:
            raise OrderError("report: nothing was recorded, expected Renderer.reserve and record before")
        found = _c.Report()
        if self.on_device:
            lib.device_copy(ctypes.byref(found), self._report._memory.pointer, ctypes.sizeof(found), self._stream)
        else:
            found = self._report
        return Report(found.visible, found.intersections, bool(found.overflowed))

    def set_recorded_scenes(self) -> None:
        """Has recorded frames show what is placed now, in the order of the renderer's stream: as many placed scenes of
        as many Gaussians as were reserved."""
        lib.renderer_set_recorded_scenes(self._open())

    @property
    def recorded_scenes(self) -> RecordedScenes:
        """Where recorded frames read poses and opacities, until the next `reserve` or `trim`. Work in the order of the
        renderer's stream may write them, and recorded frames that run later show them, until `set_recorded_scenes`.
        OrderError unless placed scenes were reserved: one scene or range that stands by itself is drawn as a scene
        alone."""
        handle = self._open()
        struct = _c.RecordedScenes()
        lib.renderer_recorded_scenes(handle, ctypes.byref(struct))
        return RecordedScenes._of(struct, handle, self._device, self._stream)

    @property
    def refused_scenes(self) -> List[int]:
        """Placements that a device did not draw in the last recorded frame, because what was written to
        `recorded_scenes` is not valid, such as a matrix that is no rotation. A host refuses to record. Waits."""
        struct = _c.RecordedScenes()
        lib.renderer_recorded_scenes(self._open(), ctypes.byref(struct))
        refused = np.empty(struct.count, np.uint8)
        lib.renderer_refused_scenes(self._open(), refused.ctypes.data, refused.size)
        return np.flatnonzero(refused).tolist()

    def wait(self) -> None:
        """Returns when all frames so far are finished."""
        lib.renderer_wait(self._open())

    def pick(self, x: int, y: int, *, view: int = 0) -> Picked:
        """What the last frame shows at column `x` and row `y` of image `view`. Raises as `pick_rectangle`."""
        found = self.pick_rectangle(x, y, 1, 1, view=view)[0, 0].item()
        return Picked(*(None if value == _c.NOTHING else value for value in found))

    def pick_rectangle(self, x: int, y: int, width: int, height: int, *, view: int = 0) -> np.ndarray:
        """As `pick`, of at most 64x64 pixels from column `x` and row `y` on: [height, width] with the fields of
        `Picked`, where `NOTHING` stands for None.

        Waits, and does not look at occluders. OrderError before the first frame, and after `trim` or a frame that
        failed; InvalidArgument for an image that there is not and a rectangle that does not lie in it.
        """
        numbers = [_checks.whole(view, "pick: view", 0)]
        for name, number in (("x", x), ("y", y), ("width", width), ("height", height)):
            numbers.append(_checks.whole(number, f"pick: {name}"))
        handle = self._open()
        self._check_device()
        # The library refuses sides out of range before it writes.
        sides = [min(max(side, 0), _c.MAX_PICK_SIDE) for side in reversed(numbers[3:])]
        picked = np.empty(sides, _c.Picked)
        lib.renderer_pick(handle, *numbers, picked.ctypes.data)
        return picked

    @property
    def times(self) -> Times:
        """Of the last frame."""
        struct = _c.Times()
        lib.renderer_times(self._open(), ctypes.byref(struct))
        return _members(struct, Times)

    @property
    def statistics(self) -> Statistics:
        """Of the last frame."""
        struct = _c.Statistics()
        lib.renderer_statistics(self._open(), ctypes.byref(struct))
        return _members(struct, Statistics)

    @property
    def visible_by_scene(self) -> List[int]:
        """Splats of each placement in the last frame, or of each of `Cut.scenes`, all images together. Waits, and
        brings 4 bytes a splat to the host. OrderError before a frame and after one that was recorded."""
        with self._scene_lock:
            count = max(len(self._placed), 1) if self._cut is None else self._cut.scenes
            visible = np.empty(count, np.uint64)
            lib.renderer_visible_by_scene(self._open(), visible.ctypes.data, visible.size)
        return visible.tolist()

    @property
    def memory(self) -> Memory:
        """What the renderer keeps, the scene excluded."""
        struct = _c.Memory()
        lib.renderer_memory(self._open(), ctypes.byref(struct))
        return _members(struct, Memory)

    def trim(self) -> None:
        """Waits, and gives back all memory that the renderer keeps, the scene excluded. What was reserved is
        forgotten."""
        lib.renderer_trim(self._open())
        self._recorded = self._report = None

    def _open(self) -> Handle:
        """To be held as long as it is used."""
        handle = self._handle
        if handle is None:
            raise OrderError("the renderer is closed")
        return handle

    def close(self) -> None:
        """Gives up the renderer and its scene."""
        if self._handle is not None:
            self._give_back()
        self._handle = self._recorded = self._report = None

    def __enter__(self) -> "Renderer":
        self._open()
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __repr__(self) -> str:
        if self._handle is None:
            return f"<swiftgs.Renderer {self.name} closed>"
        count = sum(map(len, self._placed))
        scenes = f"{count:,} Gaussians" if self._placed else "no scene"
        if self._cut is not None:
            scenes = f"{self._cut.splats:,} Gaussians and nodes of pages"
        elif len(self._placed) > 1:
            scenes += f" in {len(self._placed)} placed scenes"
        return f"<swiftgs.Renderer {self.name} on {self.device_name}, {scenes}>"
