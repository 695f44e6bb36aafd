# SPDX-License-Identifier: Apache-2.0
"""Scenes larger than the memory: page files, and pools that draw them within a budget."""
import ctypes
from typing import Any, NamedTuple, Optional, Sequence, Tuple, Union

from . import _c, _checks
from ._c import Handle, lib
from ._camera import Camera
from ._errors import InvalidArgument, OrderError
from ._frame import Frame
from ._placement import Placement
from ._renderer import Renderer
from ._scene import Path


class Pages:
    """An open page file, as `swiftgs pages` writes it. `open_pages` opens one."""

    def __init__(self, path: Path) -> None:
        self._handle = Handle(lib.pages_free, lib.pages_open, _checks.path(path))
        info = _c.PagesInfo()
        lib.pages_get_info(self._handle, ctypes.byref(info))
        self.gaussians: int = info.gaussians  #: of all leaves
        self.pages: int = info.pages  #: leaves, and those above them
        self.page_size: int = info.page_size  #: most Gaussians or nodes of a page
        self.sh_degree: int = info.sh_degree
        self.origin: Tuple[float, ...] = tuple(info.origin)  #: as `Scene.origin`
        self.lower: Tuple[float, ...] = tuple(info.lower)  #: least coordinates of all means, less `origin`
        self.upper: Tuple[float, ...] = tuple(info.upper)  #: greatest

    def __len__(self) -> int:
        return self.gaussians

    def __repr__(self) -> str:
        return f"<swiftgs.Pages {self.gaussians:,} Gaussians in {self.pages} pages>"


def open_pages(path: Path) -> Pages:
    """Opens a page file and reads its table, but no page."""
    return Pages(path)


class Cut(NamedTuple):
    """The pages that a frame draws."""

    is_settled: bool  #: nothing is missing but pages that fail, and those below them
    splats: int  #: Gaussians and nodes that it draws
    wanted: int  #: at most, once all pages are there
    missing: int  #: pages that are not in memory yet
    pixels: float  #: error that the budgets allow when nothing is missing
    resident: int  #: pages in memory
    bytes: int  #: that pages take
    failure: Optional[str]  #: why a page could not be read
    scenes: int  #: placed scenes of a frame that shows it, as `Renderer.visible_by_scene` counts
    #: PSNR beside the scene of the last complete cut that was measured: of its pages alone in front of the
    #: background; NaN: none yet
    estimated_db: float


def _cut_of(told: _c.Cut) -> Cut:
    """Read before the next cut, with which the text of a failure goes."""
    members = {name: getattr(told, name) for name in Cut._fields}
    failure = members["failure"]
    members.update(is_settled=bool(told.is_settled), failure=failure and failure.decode(errors="replace"))
    return Cut(**members)


class NamedNode(NamedTuple):
    """What a number in a frame of pages names."""

    is_gaussian: bool  #: rather than a node of a page, which stands for several
    scene: int  #: index of the placement
    page: int
    number: int  #: of the Gaussian in the source, or of the node in its page


class PagePool:
    """Pages in the memory of a renderer, which draws what `cut` chooses.

    >>> pool = PagePool(renderer, open_pages("city.sgp"), bytes=4 << 30)
    >>> pool.cut(camera)
    >>> renderer.render(camera)
    """

    def __init__(self, renderer: Renderer, pages: Union[Pages, Sequence[Pages]], *,
                 bytes: int = 0,  # pylint: disable=redefined-builtin
                 upload_per_frame: int = 0, waiting: int = 0, estimate: int = 0) -> None:
        """`bytes` bounds all pages in memory, 0 for 2 GB; `upload_per_frame` what a cut uploads, 0 for 16 MiB; and
        `waiting` pages that were read and not uploaded, 0 for 64 MiB. A thread measures `Cut.estimated_db` by
        pages that it reads into `estimate` bytes of the host, 0 for not at all. Each file is placed where it stands."""
        self._renderer = _checks.of_type(renderer, Renderer, "renderer")
        files = [pages] if isinstance(pages, Pages) else _checks.listed(pages, "pages")
        handles = [_checks.of_type(each, Pages, "pages", "; swiftgs.open_pages opens one")._handle for each in files]
        pointers = (ctypes.c_void_p * len(handles))(*(each.pointer for each in handles))
        options = _c.PoolOptions(**{name: _checks.whole(value, name, 0, 2**64) for name, value in (
            ("bytes", bytes), ("upload_per_frame", upload_per_frame), ("waiting", waiting), ("estimate", estimate))})
        handle = renderer._open()
        self._handle: Optional[Handle] = Handle(lib.pool_free, lib.pool_create, handle, pointers, len(handles),
                                                ctypes.byref(options), outlived_by=handle)

    def place(self, placements: Sequence[Placement]) -> None:
        """Places files by their indices, as wholes, any number of times."""
        found = _checks.listed(placements, "placements")
        structs: Any = (_c.Placement * len(found))()
        for index, placement in enumerate(found):
            structs[index] = _checks.of_type(placement, Placement, f"placement {index}")._struct()
        lib.pool_place(self._open(), structs, len(structs))

    def cut(self, cameras: Union[Camera, Sequence[Camera]], *, pixels: float = 1, splats: int = 0, blend: float = 0,
            wait: bool = False, out: Optional[Frame] = None,
            ahead: Union[Camera, Sequence[Camera], None] = None) -> Cut:
        """Chooses pages with errors of at most `pixels`, 0 for all Gaussians, and at most so many `splats`, 0 for any.
        A page fades into its children while its error rises from `pixels` to `pixels` (1 + `blend`).
        The renderer shows them until another scene is set. Without `wait` it does not wait for files: frames draw what
        is there, and later cuts more. `out` is a frame that will be drawn, where its conventions or sizes matter.
        Pages that the cameras `ahead` need come next; without them, the cameras' in ten frames if they go on as they
        do."""
        frame = Renderer._new_frame(cameras, "rgb", {}) if out is None else _checks.of_type(out, Frame, "out")
        frame._aim(cameras)
        later = None if ahead is None else Renderer._new_frame(ahead, "rgb", {})
        if later is not None and ahead is not None:
            later._aim(ahead)
        limit, fading = _checks.real(pixels, "pixels"), _checks.real(blend, "blend")
        goal = _c.CutGoal(pixels=limit if limit != 0 else -1, splats=_checks.whole(splats, "splats", 0, 2**64),
                          blend=fading)
        for name, value in (("pixels", limit), ("blend", fading)):
            if value < 0:
                raise InvalidArgument(f"{name} is {value:g}, expected 0 or more")
        told = _c.Cut()
        with self._renderer._scene_lock:
            self._renderer._change(lib.pool_cut, self._open(), frame._argument,
                                   None if later is None else later._argument, ctypes.byref(goal), ctypes.byref(told))
            self._renderer._cut = cut = _cut_of(told)
            if wait:
                lib.pool_wait(self._open(), ctypes.byref(told))
                self._renderer._cut = cut = _cut_of(told)
        return cut

    def named(self, number: int) -> NamedNode:
        """What a number that a pick or the plane `id` of a frame of the last cut has names."""
        told = _c.NamedNode()
        lib.pool_named(self._open(), _checks.whole(number, "number", 0, 2**32), ctypes.byref(told))
        return NamedNode(bool(told.is_gaussian), told.scene, told.page, told.number)

    def _open(self) -> Handle:
        if self._handle is None:
            raise OrderError("the pool is closed")
        return self._handle

    def close(self) -> None:
        """Gives up the pages, but for those that the renderer shows until it shows something else."""
        self._handle = None
