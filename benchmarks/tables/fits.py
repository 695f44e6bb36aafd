# SPDX-License-Identifier: Apache-2.0
"""Power laws that fit measured growth, and where one curve passes another."""
import math


def exponent(points):
    """Of the power law that fits (x, y) best, by least squares of logarithms; None for fewer than two x."""
    xs, ys = [math.log(x) for x, _ in points], [math.log(y) for _, y in points]
    mx, my = sum(xs) / len(xs), sum(ys) / len(ys)
    spread = sum((x - mx) ** 2 for x in xs)
    return sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / spread if spread > 0 else None


def crossing(x0, x1, first, second):
    """The x between x0 and x1 where two power laws meet that run through (x0, y0) and (x1, y1), each given as (y0, y1);
    the first is above at x0 and the second at x1."""
    apart = math.log(first[0] / second[0])
    closed = apart - math.log(first[1] / second[1])
    return math.exp(math.log(x0) + (math.log(x1) - math.log(x0)) * apart / closed)


def dominance(xs, curves):
    """[(name, x)]: which of `curves`, {name: y at each x}, is largest, and from which x on."""
    found = []
    for n, x in enumerate(xs):
        largest = max(curves, key=lambda name: curves[name][n])
        if found and largest != found[-1][0]:
            before = found[-1][0]
            x = crossing(xs[n - 1], x, *((curves[name][n - 1], curves[name][n]) for name in (before, largest)))
        if not found or largest != found[-1][0]:
            found.append((largest, x))
    return found
