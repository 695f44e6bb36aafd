# SPDX-License-Identifier: Apache-2.0
"""Power laws that fit measured growth, and where one curve passes another."""
import collections
import math


class PowerLaw(collections.namedtuple("PowerLaw", "exponent x y")):
    """y * (at / x) ** exponent: a line through (x, y) in logarithms."""

    def __call__(self, at):
        return self.y * (at / self.x) ** self.exponent


def fit(points):
    """The PowerLaw that fits (x, y) best, by least squares of logarithms; through both where there are two. None for
    fewer than two x."""
    xs, ys = [math.log(x) for x, _ in points], [math.log(y) for _, y in points]
    mx, my = sum(xs) / len(xs), sum(ys) / len(ys)
    spread = sum((x - mx) ** 2 for x in xs)
    if not spread > 0:
        return None
    return PowerLaw(sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / spread, math.exp(mx), math.exp(my))


def crossing(first, second):
    """The x where two laws meet that were fitted at the same x."""
    return first.x * (second.y / first.y) ** (1 / (first.exponent - second.exponent))


def dominance(xs, curves):
    """[(name, x)]: which of `curves`, {name: y at each x}, is largest, and from which x on."""
    found = []
    for n, x in enumerate(xs):
        largest = max(curves, key=lambda name: curves[name][n])
        if found and largest != found[-1][0]:
            x = crossing(*(fit([(xs[m], curves[name][m]) for m in (n - 1, n)]) for name in (found[-1][0], largest)))
        if not found or largest != found[-1][0]:
            found.append((largest, x))
    return found
