# SPDX-License-Identifier: Apache-2.0
"""Chooses rows of results, averages them over views, and knows the renderers that the paper's steps are."""
import collections
from statistics import geometric_mean, mean

from tables.results import STAGES, InputError, above_zero

THRESHOLD, SHARED = "axis-shared-threshold-", "axis-shared-"
CHOLESKY = THRESHOLD + "float-cholesky"
BOX, SQUARE, ELLIPSE = "opacity-box", "three-sigma-square", "ellipse"
BASELINE = f"standard/per-pixel/{BOX}"
VANILLA = f"standard/per-pixel/{SQUARE}"
OURS = f"adaptive/{CHOLESKY}/{ELLIPSE}"
RASTERS = ("per-pixel",) + tuple(prefix + form for prefix in (SHARED, THRESHOLD)
                                 for form in ("half-split", "float-split", "float-cholesky"))
FRAME_STAGES = STAGES[:-1]  # without the host's wall time
# Those of the paper's Table 2 and all of them together, with the baseline's bounds; then what is ours.
STEPS = (("baseline", BASELINE), ("AR", f"standard/{SHARED}half-split/{BOX}"),
         ("AR + AT", f"standard/{THRESHOLD}half-split/{BOX}"), ("ES", f"early/per-pixel/{BOX}"),
         ("ES + AES", f"adaptive/per-pixel/{BOX}"), ("all", f"adaptive/{THRESHOLD}half-split/{BOX}"))
OUR_STEPS = (("all, our terms", f"adaptive/{CHOLESKY}/{BOX}"), ("and our bounds", OURS))

Scene = collections.namedtuple("Scene", "name gaussians")


class Frames:
    """The rows of one file at the scenes' own enlargement, with one preset of conventions: at the scenes' own scale, or
    with `any_scale` at one for each scene."""

    def __init__(self, results, conventions="gsplat", any_scale=False):
        self.results, self.of, self.sizes = results, collections.defaultdict(list), {}
        scales = {}
        for row in results.rows:
            if (row.enlarge, row.conventions) == (1, conventions) and (any_scale or row.scale == 1):
                scene = Scene(row.scene, row.gaussians)
                if scales.setdefault(scene, row.scale) != row.scale:
                    raise InputError(f"{results.path}: {row.scene} at scales {scales[scene]:g} and {row.scale:g}; "
                                     "expected one")
                self.of[scene, row.name].append(row)
                self.sizes.setdefault(scene, f"{row.width}x{row.height}")
        self.scenes = list(self.sizes)
        if not self.scenes:
            raise InputError(f"{results.path}: no row with {conventions} conventions; expected some")
        runs = {(row.backend, row.threads) for row in results.rows}
        if len(runs) > 1:
            raise InputError(f"{results.path}: rows of {len(runs)} backends or numbers of threads; expected one")

    def rows(self, scene, name):
        """Of all views, in their order; InputError where the renderer was not measured."""
        if (scene, name) not in self.of:
            raise InputError(f"{self.results.path}: no row of {name} on {scene.name} with {scene.gaussians} Gaussians; "
                             "expected one for each view")
        return self.of[scene, name]

    def bounds(self, scene, sort_raster):
        """Those measured with SORT/RASTER, the widest first."""
        found = {name.rpartition("/")[2]: rows for (of, name), rows in self.of.items()
                 if of == scene and name.rpartition("/")[0] == sort_raster}
        return sorted(found, key=lambda bounds: -sum(row.intersections or 0 for row in found[bounds]))

    def mean(self, scene, name, stage="total"):
        """Milliseconds, mean over the views' medians."""
        return mean(self.needed(row, stage) for row in self.rows(scene, name))

    def needed(self, row, member):
        """A number of one of the rows, above 0."""
        return above_zero(self.results.path, row, member)[0]

    def mean_of(self, scene, name, member):
        """Mean over the views that have it; None where none has."""
        values = [getattr(row, member) for row in self.rows(scene, name) if getattr(row, member) is not None]
        return mean(values) if values else None

    def worst_psnr(self, scene, name, member="psnr_db"):
        """dB against float64, of the worst view that was compared; None where none was."""
        found = [getattr(row, member) for row in self.rows(scene, name)]
        return min((value for value in found if value is not None), default=None)

    def speed_up(self, scene, name, base, stage="total"):
        return self.mean(scene, base, stage) / self.mean(scene, name, stage)

    def speed_up_of_all(self, name, base, stage="total"):
        """Geometric mean over the scenes."""
        return geometric_mean(self.speed_up(scene, name, base, stage) for scene in self.scenes)


def gaussians(number):
    """As in 1.5 M."""
    return f"{number / 1e6:.2g} M" if number < 9.5e6 else f"{number / 1e6:.0f} M"


def label(scene):
    return f"{scene.name}, {gaussians(scene.gaussians)}"
