# SPDX-License-Identifier: Apache-2.0
"""`rasterization` with the names, shapes and defaults of gsplat 1.x, for inference."""
import dataclasses
import functools
import math
import threading
from typing import Any, Dict, Optional, Sequence, Tuple

import numpy as np

from . import _arrays, _c, _checks
from ._camera import Conventions
from ._errors import InvalidArgument, NoSuchResult, NotOffered
from ._frame import Frame
from ._gaussians import check_device
from ._renderer import Renderer

_MODES = ("RGB", "D", "ED", "RGB+D", "RGB+ED")
_CAMERA = np.dtype(_c.Camera)
_LAST_ROW = np.array([0.0, 0.0, 0.0, 1.0])
# Where a camera's rotation, translation, fx, fy, cx and cy are in 16 numbers of its view and 9 of its intrinsics.
_FROM = np.array([0, 1, 2, 4, 5, 6, 8, 9, 10, 3, 7, 11, 16, 20, 18, 21])

# Arguments that change an image or ask for another result, with the one value that does neither, in the order in which
# `rasterization` checks them.
_REFUSED: Dict[str, Any] = {
    "radius_clip": 0.0, "distributed": False, "covars": None, "with_eval3d": False, "return_normals": False,
    "global_z_order": True, "rays": None, "lidar_coeffs": None, "external_distortion_coeffs": None,
    "viewmats_rs": None}
_LENSES = {"pinhole": "perspective", "ortho": "orthographic", "fisheye": "fisheye"}
_LENS_NAMES = tuple(_LENSES)

_NAMES = {"rotations": "quats", "sh": "colors", "colours": "colors"}


class _OfThread(threading.local):
    """What a thread keeps from one call to the next."""

    def __init__(self) -> None:
        super().__init__()
        self.renderers: Dict[Optional[int], Renderer] = {}  # by device; None: the host
        self.images: Optional["_Images"] = None


_of_thread = _OfThread()


class Meta(Dict[str, Any]):
    """What `rasterization` tells beside its images."""

    def __missing__(self, key: str) -> Any:
        raise NoSuchResult(f"meta has no '{key}', expected one of {', '.join(self)}: intermediate results are not kept")


def rasterization(
        means: Any, quats: Any, scales: Any, opacities: Any, colors: Any, viewmats: Any, Ks: Any, width: int,
        height: int, near_plane: float = 0.01, far_plane: float = 1e10, radius_clip: float = 0.0, eps2d: float = 0.3,
        sh_degree: Optional[int] = None, packed: bool = True, tile_size: Optional[int] = None, backgrounds: Any = None,
        render_mode: str = "RGB", sparse_grad: bool = False, absgrad: bool = False, rasterize_mode: str = "classic",
        channel_chunk: int = 32, distributed: bool = False, camera_model: str = "pinhole", segmented: bool = False,
        covars: Any = None, with_ut: bool = False, with_eval3d: bool = False, return_normals: bool = False,
        global_z_order: bool = True, rays: Any = None, radial_coeffs: Any = None, tangential_coeffs: Any = None,
        thin_prism_coeffs: Any = None, ftheta_coeffs: Any = None, lidar_coeffs: Any = None,
        external_distortion_coeffs: Any = None, rolling_shutter: Any = None, viewmats_rs: Any = None,
        ut_params: Any = None, extra_signals: Any = None, extra_signals_sh_degree: Optional[int] = None,
        renderer_config: Any = None, *, renderer: Optional[Renderer] = None) -> Tuple[Any, Any, Meta]:
    """Draws Gaussians for a batch of cameras, as gsplat's function of this name does without gradients.

    Arrays are float32 of NumPy, PyTorch, CuPy, JAX or any library with DLPack, all on the host or all on one CUDA
    device: means [N, 3]; quats [N, 4] w, x, y, z of any length; scales [N, 3]; opacities [N]; colors [N, 3], or with
    `sh_degree` harmonics [N, K, 3], or other numbers [N, D], drawn as they are. viewmats [C, 4, 4], Ks [C, 3, 3] and
    backgrounds [C, 3] may lie on the host too, which saves a wait. All may have the same dimensions of a batch before
    these, and so have the results: each of its scenes is drawn for its own cameras, all in one frame.

    Returns colours [C, height, width, X] and alphas [C, height, width, 1] as arrays of the library of `means`, and a
    dictionary. X is 3 or D, with a depth one more, and 1 for a depth alone; `render_mode` is "RGB", "D", "ED",
    "RGB+D" or "RGB+ED". On a device nothing of the Gaussians or the images visits the host, and the images are in the
    order of the library's current stream.

    `camera_model` is "pinhole", "ortho" or "fisheye". As in gsplat, z orders Gaussians of every model, is compared with
    the planes, and is drawn as depth. OpenCV's distortion is in radial_coeffs [C, 6], or [C, 4] of a fisheye,
    tangential_coeffs [C, 2] and thin_prism_coeffs [C, 4]. Lenses are linearised at the mean of each Gaussian, also
    `with_ut`, which gsplat needs for distortion and which takes seven points of each Gaussian there.

    extra_signals [N, E] are drawn beside the colours: `render_extra_signals` [C, height, width, E] of the dictionary is
    the sum of weight times signal.

    Arguments that change no image, such as `absgrad` and `packed`, are taken and not used. Those that would change it
    are refused by name unless they have their default. `renderer` is a `Renderer` of yours, which keeps the Gaussians
    as its scene; without one each thread has its own. On a device it reads the arrays again in each frame that it
    draws, until another scene is set: write to them in the order of its stream. docs/python.md has a table of all
    arguments.
    """
    refused = (radius_clip, distributed, covars, with_eval3d, return_normals, global_z_order, rays, lidar_coeffs,
               external_distortion_coeffs, viewmats_rs)
    for (name, default), value in zip(_REFUSED.items(), refused):
        if value is not default and (default is None or value != default):
            raise NotOffered(f"rasterization: {name} is {_short(value)}, expected {default!r}: nothing else is offered")
    if camera_model not in _LENS_NAMES:
        raise NotOffered(f"rasterization: camera_model is {camera_model!r}, expected 'pinhole', 'ortho' or 'fisheye': "
                         "nothing else is offered")
    if rolling_shutter is not None and "GLOBAL" not in str(rolling_shutter):
        raise NotOffered(f"rasterization: rolling_shutter is {_short(rolling_shutter)}, expected GLOBAL: nothing else "
                         "is offered")
    if render_mode not in _MODES:
        raise NotOffered(f"rasterization: render_mode is {render_mode!r}, expected one of {', '.join(_MODES)}")
    if rasterize_mode not in ("classic", "antialiased"):
        raise InvalidArgument(f"rasterization: rasterize_mode is {rasterize_mode!r}, expected 'classic' or "
                              "'antialiased'")
    if extra_signals is not None and extra_signals_sh_degree is not None:
        raise NotOffered(f"rasterization: extra_signals_sh_degree is {extra_signals_sh_degree}, expected None: signals "
                         "have no harmonics")
    # Of the backward pass, of speed, and of what is refused above.
    del sparse_grad, absgrad, packed, tile_size, channel_chunk, segmented, renderer_config
    del ftheta_coeffs, ut_params, extra_signals_sh_degree
    del with_ut  # lenses are linearised either way

    width, height = _checks.whole(width, "width", 1), _checks.whole(height, "height", 1)
    if renderer is not None:
        _checks.of_type(renderer, Renderer, "renderer")
    batch = _batch_of(means)
    if batch:
        means, quats, scales, opacities, colors, extra_signals = (
            _joined_batch(array, name, batch, ranks) for name, array, *ranks in (
                ("means", means, 2), ("quats", quats, 2), ("scales", scales, 2), ("opacities", opacities, 1),
                ("colors", colors, 2, 3), ("extra_signals", extra_signals, 2)))
        viewmats, Ks, backgrounds, radial_coeffs, tangential_coeffs, thin_prism_coeffs = (
            _joined_batch(None if array is None else _arrays.host(array, name), name, batch, [rank])
            for name, array, rank in (
                ("viewmats", viewmats, 3), ("Ks", Ks, 3), ("backgrounds", backgrounds, 2),
                ("radial_coeffs", radial_coeffs, 2), ("tangential_coeffs", tangential_coeffs, 2),
                ("thin_prism_coeffs", thin_prism_coeffs, 2)))
    views, intrinsics = _matrices(viewmats, Ks)
    count, worlds = len(views), math.prod(batch)
    in_colour = render_mode.startswith("RGB")
    coloured: Dict[str, Any] = {"colours": colors}
    if sh_degree is not None:
        coloured = {"sh": colors, "sh_degree": _checks.whole(sh_degree, "sh_degree", 0)}
    elif not in_colour:
        coloured = {"colours": means}  # drawn by nobody
    _check_shapes(coloured, count)
    features: Dict[str, Any] = {}
    if in_colour and sh_degree is None and _channels(colors, "colors") != 3:
        features["colors"], coloured = colors, {"colours": means}
        if backgrounds is not None:
            raise NotOffered(f"rasterization: backgrounds is {_short(backgrounds)}, expected None for colors of "
                             f"{_channels(colors, 'colors')} channels")
    if extra_signals is not None:
        features["extra_signals"] = extra_signals
    channels = [_channels(array, name) for name, array in features.items()]
    device = _arrays.device_of(means)
    check_device(device, "means")
    drawing = renderer or _renderer(device)
    if (device is not None) != drawing.on_device:
        raise InvalidArgument(f"means lies on {'the host' if device is None else f'CUDA device {device}'}, expected "
                              f"the memory of the renderer '{drawing.name}'")

    library = _arrays.library_of(means)
    if device is not None and library not in _arrays.LIBRARIES:
        alone = f"for arrays of '{library}': planes are put together by {', '.join(_arrays.LIBRARIES)} alone"
        if render_mode not in ("RGB", "ED"):
            raise NotOffered(f"rasterization: render_mode is '{render_mode}', expected 'RGB' or 'ED' {alone}")
        if len(features) > 1:
            raise NotOffered(f"rasterization: extra_signals is given, expected None or colors of 3 channels {alone}")
    planes = {"alpha": 1}
    if in_colour and "colors" not in features:
        planes["colour"] = 3
    if render_mode != "RGB":
        planes["depth"] = 1
    if features:
        planes["features"] = sum(channels)
    arrays = {name: _arrays.empty(means, (count, height, width, wide), device) for name, wide in planes.items()}
    conventions = _conventions(_checks.real(near_plane, "near_plane"), _checks.real(far_plane, "far_plane"),
                               _checks.real(eps2d, "eps2d"), rasterize_mode == "antialiased")
    coefficients = radial_coeffs, tangential_coeffs, thin_prism_coeffs
    is_distorted = not (radial_coeffs is tangential_coeffs is thin_prism_coeffs is None)
    has_background = backgrounds is not None and in_colour
    key = (count, width, height, planes, device, conventions, camera_model, worlds, is_distorted, has_background)
    images, _of_thread.images = _of_thread.images, None  # a failed call keeps none
    if images is None or images.key != key:
        images = _Images(key, Frame(**arrays, conventions=conventions), camera_model, worlds)
    images.frame._draw_into(arrays)
    images.aim(views, intrinsics)
    if is_distorted:
        _distort(images.cameras, camera_model, *coefficients)
    if has_background:
        images.frame.background = _backgrounds(backgrounds, count)
    options = dict(coloured, any_rotations=True, names=_NAMES)
    if features:
        options.update(features=_joined(features), names=dict(_NAMES, features=" and ".join(features)))
    with drawing._scene_lock:
        try:
            drawing._draw_gaussians(images.frame, worlds, (means, scales, quats, opacities, None), options)
        finally:
            if not renderer:
                drawing._borrowed = None  # the thread's own renderer is given arrays by each call

    images.frame._sources = {}  # the arrays are the caller's
    _of_thread.images = images
    if batch or library == "jax":
        arrays = {name: _parted(_arrays.returned(means, array), batch, worlds) for name, array in arrays.items()}
    colour, alpha, depth, signals = map(arrays.get, ("colour", "alpha", "depth", "features"))
    meta = Meta(width=width, height=height, n_batches=worlds, n_cameras=count // worlds, tile_size=16,
                renderer=drawing.name)
    if "colors" in features:
        colour = signals if len(features) == 1 else signals[..., :channels[0]]
    if extra_signals is not None:
        meta["render_extra_signals"] = signals if len(features) == 1 else signals[..., channels[0]:]
    if depth is not None and not render_mode.endswith("ED"):
        depth = depth * alpha
    if colour is not None and depth is not None:
        return _arrays.concatenate(means, [colour, depth]), alpha, meta
    return depth if colour is None else colour, alpha, meta


class _Images:
    """The frame and cameras of calls with one `key`. Each call sets arrays, matrices, and coefficients and backgrounds
    if the key has them."""

    def __init__(self, key: Tuple[Any, ...], frame: Frame, model: str, worlds: int) -> None:
        frame._let_go()
        self.key, self.frame, count = key, frame, len(frame)
        self.cameras = np.frombuffer(frame._cameras, _CAMERA)
        for name, value in {"size": _CAMERA.itemsize, "width": frame.width, "height": frame.height,
                            "lens": _c.LENSES.index(_LENSES[model])}.items():
            self.cameras[name] = value
        if worlds > 1:
            frame._table["first_shown"], frame._table["shown_count"] = np.arange(count) * worlds // count, 1
        # Each camera's view [4, 4] and intrinsics [3, 3] in a row; `_numbers` is the part of its struct that they set.
        self._given = np.empty((count, 25))
        self._views, self._intrinsics = self._given[:, :16].reshape(-1, 4, 4), self._given[:, 16:].reshape(-1, 3, 3)
        self._numbers = np.ndarray((count, len(_FROM)), np.float64, frame._cameras, _c.Camera.rotation.offset,
                                   (_CAMERA.itemsize, 8))

    def aim(self, views: np.ndarray, intrinsics: np.ndarray) -> None:
        """Sets the cameras by matrices [C, 4, 4] and [C, 3, 3]."""
        self._views[:], self._intrinsics[:] = views, intrinsics
        self._numbers[:] = self._given.take(_FROM, axis=1)


_GSPLAT = dataclasses.replace(Conventions.named("gsplat"), depth="z")


@functools.lru_cache(maxsize=16)
def _conventions(near_plane: float, far_plane: float, blur: float, antialiased: bool) -> Conventions:
    return dataclasses.replace(_GSPLAT, near_plane=near_plane, far_plane=far_plane, blur=blur, antialiased=antialiased)


def _short(value: Any) -> str:
    shape = getattr(value, "shape", None)
    return repr(value) if shape is None else f"an array of the shape {tuple(shape)}"


def _renderer(device: Optional[int]) -> Renderer:
    kept = _of_thread.renderers
    if device not in kept:
        kept[device] = Renderer("cpu" if device is None else "cuda")
    return kept[device]


def _channels(array: Any, name: str) -> int:
    """Of numbers [N, channels]. What has another shape is refused where it is read."""
    shape = array.shape if hasattr(array, "shape") else _arrays.read(array, name, None).shape
    return int(shape[-1]) if len(shape) == 2 else 3


def _joined(features: Dict[str, Any]) -> Any:
    """[N, channels of all], by the library of the first."""
    arrays = list(features.values())
    if len(arrays) < 2:
        return arrays[0] if arrays else None
    if _arrays.library_of(arrays[0]) not in _arrays.LIBRARIES:
        arrays = [_arrays.host(array, name) for name, array in features.items()]
    return _arrays.concatenate(arrays[0], arrays)


def _batch_of(means: Any) -> Tuple[int, ...]:
    """Dimensions before [N, 3]."""
    batch = tuple(getattr(means, "shape", ()))[:-2]
    if math.prod(batch) == 0:
        raise InvalidArgument(f"means has the shape {tuple(means.shape)}, expected a batch of one scene or more")
    return batch


def _joined_batch(array: Any, name: str, batch: Tuple[int, ...], ranks: Sequence[int]) -> Any:
    """[..., N, *] as [all, *]. `ranks`: how many dimensions there may be beside those of the batch."""
    if array is None:
        return None
    shape, after = tuple(getattr(array, "shape", ())), len(batch)
    if shape[:after] != batch or len(shape) - after not in ranks:
        raise InvalidArgument(f"{name} has the shape {shape}, expected the batch {batch} of means first, and "
                              f"{' or '.join(map(str, ranks))} dimensions after it")
    if not hasattr(array, "reshape"):
        raise NotOffered(f"rasterization: {name} has a batch of {batch}, expected none of arrays of "
                         f"'{_arrays.library_of(array)}', which are not reshaped")
    return array.reshape((math.prod(shape[:after + 1]), *shape[after + 1:]))


def _parted(plane: Any, batch: Tuple[int, ...], worlds: int) -> Any:
    """The opposite, of images."""
    return plane.reshape((*batch, plane.shape[0] // worlds, *plane.shape[1:])) if batch else plane


def _check_shapes(coloured: Dict[str, Any], count: int) -> None:
    """Refuses by name what gsplat takes and this does not."""
    if "sh" in coloured:
        if coloured["sh_degree"] > 3:
            raise NotOffered(f"rasterization: sh_degree is {coloured['sh_degree']}, expected 0 to 3")
        return
    colours = tuple(getattr(coloured["colours"], "shape", ()))
    if len(colours) == 3 and colours[:1] == (count,):
        raise NotOffered(f"rasterization: colors has the shape {colours}, expected (N, 3): colours of each camera are "
                         "not offered, call it for each")


def _matrices(viewmats: Any, intrinsics: Any) -> Tuple[np.ndarray, np.ndarray]:
    """[C, 4, 4] and [C, 3, 3] on the host."""
    views, ks = _arrays.host(viewmats, "viewmats"), _arrays.host(intrinsics, "Ks")
    if views.ndim != 3 or views.shape[1:] != (4, 4) or len(views) == 0:
        raise InvalidArgument(f"viewmats has the shape {views.shape}, expected (C, 4, 4)")
    if ks.shape != (len(views), 3, 3):
        raise InvalidArgument(f"Ks has the shape {ks.shape}, expected ({len(views)}, 3, 3)")
    if np.count_nonzero(views[:, 3] != _LAST_ROW):
        raise InvalidArgument("viewmats: expected 0, 0, 0, 1 in the last row")
    if np.count_nonzero(ks[:, 0, 1]) or np.count_nonzero(ks[:, 1, 0]):
        raise NotOffered("rasterization: Ks has a skew, expected 0 beside the focal lengths")
    return views, ks


def _distort(cameras: np.ndarray, model: str, radial: Any, tangential: Any, prism: Any) -> None:
    """Sets the coefficients of `cameras`. What gsplat draws otherwise is refused by name."""
    count = len(cameras)
    found = _coefficients("radial_coeffs", radial, (count, 4 if model == "fisheye" else 6))
    if model == "ortho":
        _refuse("radial_coeffs", radial, found, "an orthographic lens has no distortion")
    elif model == "fisheye":
        cameras["radial"] = found
    else:
        cameras["radial"][:, :3], cameras["rational"] = found[:, :3], found[:, 3:]
    found = _coefficients("tangential_coeffs", tangential, (count, 2))
    if model == "pinhole":
        cameras["tangential"] = found
    else:
        _refuse("tangential_coeffs", tangential, found, "gsplat has them of pinholes alone")
    found = _coefficients("thin_prism_coeffs", prism, (count, 4))
    if model != "pinhole":
        _refuse("thin_prism_coeffs", prism, found, "gsplat has them of pinholes alone")
    _refuse("thin_prism_coeffs", prism, found[:, 1::2], "the second and fourth, of r^4, are not offered")
    cameras["prism"] = found[:, ::2]


def _coefficients(name: str, given: Any, shape: Tuple[int, int]) -> np.ndarray:
    if given is None:
        return np.zeros(shape)
    found = _arrays.host(given, name)
    if found.shape != shape:
        raise InvalidArgument(f"{name} has the shape {found.shape}, expected {shape}")
    return found


def _refuse(name: str, given: Any, found: np.ndarray, why: str) -> None:
    if found.any():
        raise NotOffered(f"rasterization: {name} is {_short(given)}, expected None or zeros: {why}")


def _backgrounds(backgrounds: Any, count: int) -> np.ndarray:
    found = _arrays.host(backgrounds, "backgrounds")
    if found.shape != (count, 3):
        raise InvalidArgument(f"backgrounds has the shape {found.shape}, expected ({count}, 3)")
    return found
