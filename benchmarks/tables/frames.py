# SPDX-License-Identifier: Apache-2.0
"""Chooses rows of results, averages them over views, and knows the renderers that the paper's steps are."""
import collections
import math
from statistics import geometric_mean, mean

from tables.markdown import prose
from tables.results import STAGES, InputError

THRESHOLD, SHARED = "axis-shared-threshold-", "axis-shared-"
CHOLESKY = THRESHOLD + "float-cholesky"
BOX, SQUARE, ELLIPSE = "opacity-box", "three-sigma-square", "ellipse"
BASELINE = f"standard/per-pixel/{BOX}"
VANILLA = f"standard/per-pixel/{SQUARE}"
OURS, BEST = (f"{sort}/{CHOLESKY}/{ELLIPSE}" for sort in ("adaptive", "early"))
RASTERS = ("per-pixel",) + tuple(prefix + form for prefix in (SHARED, THRESHOLD)
                                 for form in ("half-split", "float-split", "float-cholesky"))
FRAME_STAGES = STAGES[:-1]  # without the host's wall time
# Those of the paper's Table 2 and all of them together, with the baseline's bounds; then what is ours.
STEPS = (("baseline", BASELINE), ("AR", f"standard/{SHARED}half-split/{BOX}"),
         ("AR + AT", f"standard/{THRESHOLD}half-split/{BOX}"), ("ES", f"early/per-pixel/{BOX}"),
         ("ES + AES", f"adaptive/per-pixel/{BOX}"), ("all", f"adaptive/{THRESHOLD}half-split/{BOX}"))
OUR_STEPS = (("all, our terms", f"adaptive/{CHOLESKY}/{BOX}"), ("and our bounds", OURS))

# A scene as it was measured: of a capture's own frames scale and enlarge are 1.
Scene = collections.namedtuple("Scene", "name gaussians scale enlarge", defaults=(1, 1))


class Frames:
    """The rows of one file with one preset of conventions, of one backend and number of threads: those of a GPU if there
    are any, else those of most threads. Of a scene they are the rows at its own scale and enlargement, or else those
    nearest to it. A renderer that was not measured has no rows, and times that are None; `missing` names it."""

    def __init__(self, results, conventions="gsplat"):
        rows = [row for row in results.rows if row.conventions == conventions]
        if not rows:
            found = ", ".join(sorted({row.conventions for row in results.rows})) or "no row"
            raise InputError(f"{results.path}: found {found}; expected rows with {conventions} conventions")
        self.results, self.of, self.sizes = results, collections.defaultdict(list), {}
        self.missing = {}
        self.backend, self.threads = min(((row.backend, row.threads) for row in rows), key=preference)
        rows = [row for row in rows if (row.backend, row.threads) == (self.backend, self.threads)]
        nearest = {}
        for row in rows:
            of = row.scene, row.gaussians
            nearest[of] = min(nearest.get(of, (row.scale, row.enlarge)), (row.scale, row.enlarge), key=from_its_own)
        for row in rows:
            if (row.scale, row.enlarge) == nearest[row.scene, row.gaussians]:
                scene = Scene(row.scene, row.gaussians, row.scale, row.enlarge)
                self.of[scene, row.name].append(row)
                self.sizes.setdefault(scene, f"{row.width}x{row.height}")
        self.scenes = list(self.sizes)

    def rows(self, scene, name):
        """Of all views, in their order; none where the renderer was not measured."""
        found = self.of.get((scene, name), [])
        if not found:
            self.missing[scene, name] = True
        return found

    def first_row(self, scene, name):
        """Of the first view; InputError where the renderer was not measured."""
        if (scene, name) not in self.of:
            raise InputError(f"{self.results.path}: no row of {name} on {scene.name} with {scene.gaussians} Gaussians; "
                             "expected one for each view")
        return self.of[scene, name][0]

    def with_missing(self, text):
        """`text`, and a sentence about what it has no number of."""
        if not self.missing:
            return text
        names = sorted({name for _, name in self.missing})
        return f"{text}\n\n" + prose(f"Not measured on every scene: {', '.join(f'`{name}`' for name in names)}.")

    def spread(self, stage="total"):
        """How many times as long the same work takes when it is measured again, at most: the adaptive sort, which has
        decided, against the better of the two that it chooses from. None where a file has no such rows."""
        ratios = [ratio for of_renderer in self.repeated(stage) for ratio in of_renderer]
        return max((max(ratio, 1 / ratio) for ratio in ratios), default=None)

    def spread_of_all(self, stage="total"):
        """The same of geometric means over the scenes."""
        means = [geometric_mean(ratios) for ratios in self.repeated(stage) if ratios]
        return max((max(ratio, 1 / ratio) for ratio in means), default=None)

    def repeated(self, stage):
        """[[ratio, a scene each], a pair of rasterizer and bounds each]"""
        found = []
        for rest in dict.fromkeys(name.partition("/")[2] for _, name in self.of):
            found.append([])
            for scene in self.scenes:
                names = [f"{sort}/{rest}" for sort in ("adaptive", "standard", "early")]
                if all((scene, name) in self.of for name in names):
                    adaptive, *others = [self.mean(scene, name, stage) for name in names]
                    found[-1].append(adaptive / min(others))
        return found

    def mean(self, scene, name, stage="total"):
        """Milliseconds, mean over the views' medians; None where there is no row."""
        return average([row.median(stage) for row in self.rows(scene, name)])

    def mean_of(self, scene, name, member):
        """Mean over the views that have it; None where none has."""
        return average([getattr(row, member) for row in self.rows(scene, name)])

    def worst_psnr(self, scene, name, member="psnr_db"):
        """dB against float64, of the worst view that was compared; None where none was."""
        found = [getattr(row, member) for row in self.rows(scene, name)]
        return min((value for value in found if value is not None), default=None)

    def worst_of_all(self, name, scenes=None):
        """The same of the worst scene."""
        return min(known(self.worst_psnr(scene, name) for scene in scenes or self.scenes), default=None)

    def speed_up(self, scene, name, base, stage="total"):
        times_ = self.mean(scene, base, stage), self.mean(scene, name, stage)
        return None if None in times_ else times_[0] / times_[1]

    def speed_up_of_all(self, name, base, stage="total"):
        """Geometric mean over the scenes that have both; None where none has."""
        found = known(self.speed_up(scene, name, base, stage) for scene in self.scenes)
        return geometric_mean(found) if found else None


def preference(run):
    backend, threads = run
    return ("cuda", "cpu").index(backend) if backend in ("cuda", "cpu") else 2, -threads


def from_its_own(variant):
    """Sorts (scale, enlargement): the scene's own first, then larger images before smaller ones."""
    scale, enlarge = variant
    return abs(math.log(enlarge)) if enlarge > 0 else math.inf, scale != 1, -scale


def known(values):
    return [value for value in values if value is not None]


def average(values):
    """Of those that are known; None where none is."""
    found = known(values)
    return mean(found) if found else None


def gaussians(number):
    """As in 1.5 M."""
    return f"{number / 1e6:.2g} M" if number < 9.5e6 else f"{number / 1e6:.0f} M"


def label(scene):
    variant = (f", scale {scene.scale:g}" if scene.scale != 1 else "") + \
        (f", enlarged {scene.enlarge:g}" if scene.enlarge != 1 else "")
    return f"{scene.name}, {gaussians(scene.gaussians)}{variant}"
