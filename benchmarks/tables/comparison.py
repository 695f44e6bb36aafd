# SPDX-License-Identifier: Apache-2.0
"""What moved between two result files beyond its noise.

A row's stage moved when its ratio is beyond the threshold and the confidence intervals of its two medians do not
overlap. Among thousands of stages some pairs of 95 % intervals are apart by chance, so each is first widened by the
factor that leaves all comparisons together one chance in twenty to name anything (`widening`). An interval of few
frames may be narrow by chance, the more so as frames end when it is; it counts as no narrower than is usual for that
stage of that renderer. Fewer than six frames have no such interval, and their times are left out.

Small changes hide in single rows. So the ratios of a renderer's stage in all rows are averaged too, and their
geometric mean moved when it is beyond the threshold and farther from 1 than its noise: that of the rows, or the spread
of the ratios, whichever is more.

A frame that is slower because one of its stages is has one reason. So `total` and `wall` are judged without what the
stages added that moved, and `wall` without what `total` added if that moved on top.
"""
import collections
import dataclasses
import math
import statistics

from tables.results import STAGES, Duration

NORMAL = statistics.NormalDist()
CHANCE = 0.05
HALF_WIDTH = NORMAL.inv_cdf(0.975)  # of a 95 % interval, in standard errors
FRAMES = 6  # that a 95 % interval of a median takes: all of n are on one side of it once in 2^(n - 1) times
PARTS = ("project", "sort", "raster")  # of a frame; total and wall hold them
MACHINE = ("cpu", "cores", "gpu", "driver", "cuda", "compiler", "flags", "system")
COUNTS = ("visible", "intersections", "contributing_pairs")
MEMORY = ("device_bytes", "host_bytes")
# By how much a value may differ without a word: (relative, absolute).
TOLERANCES = {"max_abs": (0.05, 1e-6), "psnr_db": (0, 0.05), "cut_psnr_db": (0, 0.05), "ssim": (0, 1e-5),
              "photo_psnr_db": (0, 0.005), "photo_ssim": (0, 1e-5),
              **{name: (1e-6, 0) for name in COUNTS}, **{name: (0.01, 0) for name in MEMORY}}


@dataclasses.dataclass(frozen=True)
class Move:
    """Something that moved: `what` of a row of both files. `worse` where it is slower or less exact."""
    row: object
    what: str
    before: float
    after: float
    worse: bool

    @property
    def ratio(self):
        return self.after / self.before if self.before else math.inf


@dataclasses.dataclass(frozen=True)
class Mean:
    """The geometric mean of the ratios, after through before, of a renderer's stage in `rows` rows, with limits that
    all means together exceed by chance once in twenty times."""
    renderer: str
    stage: str
    rows: int
    ratio: float
    low: float
    high: float


@dataclasses.dataclass(frozen=True)
class Comparison:
    pairs: list
    untimed: int  # how many of the pairs have a row of fewer than FRAMES, whose times are not compared
    only_before: list
    only_after: list
    machines: list
    moves: list
    means: list

    @property
    def worse(self):
        return any(move.worse for move in self.moves) or any(mean.ratio > 1 for mean in self.means)


def quantile(comparisons):
    """How many standard errors the largest of so many differences stays below, but for one time in twenty."""
    return NORMAL.inv_cdf(1 - CHANCE / (2 * max(comparisons, 1)))


def widening(comparisons):
    """The factor for 95 % intervals: two of equal width are apart by chance where the difference is beyond
    HALF_WIDTH * sqrt(2) of its standard errors, which is enough for ten comparisons."""
    return max(1.0, quantile(comparisons) / (HALF_WIDTH * math.sqrt(2)))


def beyond(ratio, threshold):
    return ratio > 1 + threshold or ratio < 1 / (1 + threshold)


def apart(before, after, factor, usual):
    """Whether the intervals of two durations are, each no narrower than the standard error `usual` makes it."""
    low, high = (before, after) if before.median < after.median else (after, before)
    least = HALF_WIDTH * usual
    above = max(low.high - low.median, least * low.median)
    below = max(high.median - high.low, least * high.median)
    return low.median + factor * above < high.median - factor * below


def usual_errors(pairs):
    """{(renderer, stage): median of the standard errors of both files}"""
    of = collections.defaultdict(list)
    for pair in pairs:
        for row in pair:
            for stage in STAGES:
                of[row.renderer, stage].append(standard_error(row.ms[stage]))
    return {key: statistics.median(errors) for key, errors in of.items()}


def unexplained(before, after, stage, moved):
    """The duration of `stage` in `after`, less what those of `moved` added that it holds, whose noise its interval has
    too. Medians do not add up, so it may be negative."""
    found = after.ms[stage]
    held = () if stage in PARTS else ("total",) if stage == "wall" and "total" in moved else PARTS
    parts = [part for part in held if part in moved]
    median = found.median - sum(after.ms[part].median - before.ms[part].median for part in parts)
    noise = math.hypot(*((row.ms[part].high - row.ms[part].low) / 2 for part in parts for row in (before, after)))
    return Duration(median, median - math.hypot(found.median - found.low, noise),
                    median + math.hypot(found.high - found.median, noise))


def moved_stages(pairs, threshold, of_means):
    """Moves of single rows. What moved in the mean of a renderer explains its rows too."""
    factor, usual = widening(len(pairs) * len(STAGES)), usual_errors(pairs)
    for before, after in pairs:
        moved = {mean.stage for mean in of_means if mean.renderer == after.renderer}
        for stage in STAGES:
            b, a = before.ms[stage], unexplained(before, after, stage, moved)
            if a.median <= 0 < after.ms[stage].median:  # its stages explain all of it
                continue
            if a.median != b.median and beyond(a.median / b.median if b.median else math.inf, threshold) and \
                    apart(b, a, factor, usual[after.renderer, stage]):
                moved.add(stage)
                yield Move(after, stage, b.median, after.ms[stage].median, a.median > b.median)


def moved_values(pairs):
    for before, after in pairs:
        for what, (relative, absolute) in TOLERANCES.items():
            b, a = getattr(before, what), getattr(after, what)
            if b is None or a is None or a == b or abs(a - b) <= absolute + relative * abs(b):
                continue
            yield Move(after, what, b, a, a > b if what == "max_abs" else what not in COUNTS + MEMORY and a < b)


def standard_error(duration):
    """Of the logarithm of a median, from its confidence interval."""
    if duration.low <= 0:
        return math.inf
    return math.log(duration.high / duration.low) / (2 * HALF_WIDTH)


def mean_ratio(renderer, stage, pairs, moved, comparisons):
    """The Mean, or None where a row has no time."""
    durations = [(b.ms[stage], unexplained(b, a, stage, moved)) for b, a in pairs]
    if any(b.median <= 0 or a.median <= 0 for b, a in durations):
        return None
    logs = [math.log(a.median / b.median) for b, a in durations]
    n = len(logs)
    noise = math.hypot(*(standard_error(duration) for pair in durations for duration in pair)) / n
    spread = statistics.stdev(logs) / math.sqrt(n) if n > 1 else 0
    mean, width = statistics.mean(logs), quantile(comparisons) * max(noise, spread)
    return Mean(renderer, stage, n, math.exp(mean), math.exp(mean - width), math.exp(min(mean + width, 700)))


def moved_means(pairs, threshold):
    """Means of every renderer and stage that are beyond threshold and noise."""
    of = collections.defaultdict(list)
    for before, after in pairs:
        of[before.renderer].append((before, after))
    for renderer, rows in of.items():
        moved = set()
        for stage in STAGES:
            mean = mean_ratio(renderer, stage, rows, moved, len(of) * len(STAGES))
            if mean and beyond(mean.ratio, threshold) and not mean.low <= 1 <= mean.high:
                moved.add(stage)
                yield mean


def other_machine(before, after):
    """[(member, its value before, after)] of what the two runs did not have in common."""
    return [(name, before.get(name), after.get(name)) for name in MACHINE if before.get(name) != after.get(name)]


def compare(before, after, threshold):
    """The Comparison of two Results; moves and means are those beyond noise and threshold alone."""
    old, new = {row.key: row for row in before.rows}, {row.key: row for row in after.rows}
    pairs = [(old[key], new[key]) for key in old if key in new]
    timed = [(b, a) for b, a in pairs if min(b.frames, a.frames) >= FRAMES]
    means = list(moved_means(timed, threshold))
    moves = list(moved_stages(timed, threshold, means)) + list(moved_values(pairs))
    return Comparison(pairs, len(pairs) - len(timed), [old[key] for key in old if key not in new],
                      [new[key] for key in new if key not in old], other_machine(before.machine, after.machine), moves,
                      means)
