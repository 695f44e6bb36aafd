# SPDX-License-Identifier: Apache-2.0
"""SwiftGS renders trained scenes of 3D Gaussian splatting, on CPUs and on NVIDIA GPUs.

>>> import swiftgs
>>> renderer = swiftgs.Renderer(scene=swiftgs.load("garden.spz"))
>>> renderer.render(swiftgs.load_cameras("cameras.json")[0]).save("frame.png")

`rasterization` takes the arguments of gsplat's function of that name.
"""
from ._arrays import DeviceArray, LentArray
from ._c import NOTHING, lib as _lib
from ._camera import Camera, Cameras, Conventions, OrbitView, StoredDepth, load_cameras
from ._errors import (Cancelled, CapacityError, DeviceError, Error, FileError, FormatError, InternalError,
                      InvalidArgument, InvalidType, NoSuchResult, NotLent, NotOffered, OrderError, OutOfMemory,
                      Unavailable)
from ._frame import Frame, load_image
from ._gsplat import rasterization
from ._model import RenderingModel
from ._pages import Cut, NamedNode, PagePool, Pages, open_pages
from ._placement import Clip, Placement, RecordedScenes, Tint
from ._renderer import (Memory, Picked, Renderer, RendererEntry, Report, Statistics, Times, find_renderer,
                        list_renderers)
from ._scene import Scene, SceneBounds, load

__version__ = _lib.version().decode()

__all__ = [
    "Camera", "Cameras", "Cancelled", "CapacityError", "Clip", "Conventions", "Cut", "DeviceArray", "DeviceError",
    "Error", "FileError", "FormatError", "Frame", "InternalError", "InvalidArgument", "InvalidType", "LentArray",
    "Memory", "NamedNode", "NoSuchResult", "NOTHING", "NotLent", "NotOffered", "OrbitView", "OrderError",
    "OutOfMemory", "PagePool", "Pages", "Picked", "Placement", "RecordedScenes", "Renderer", "RendererEntry",
    "RenderingModel", "Report", "Scene", "SceneBounds", "Statistics", "StoredDepth", "Times", "Tint", "Unavailable",
    "find_renderer", "list_renderers", "load", "load_cameras", "load_image", "open_pages", "rasterization"
]
