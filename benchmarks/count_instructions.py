#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts the instructions that the rasterizers' kernels spend on the alpha of a (pixel, Gaussian) pair, and prints
them as Markdown beside the numbers of SwiftGS, section 5.3.

usage: count_instructions.py FILE... [--pairs RESULTS.json] [--scene SCENE] [--listing]

FILE is what `cuobjdump -sass` prints of a program with the kernels, or what
`ncu --import REPORT --page source --csv` prints of a report with the section SourceCounters; from the latter it also
reads what was executed. RESULTS.json, of `swiftgs bench`, brings the pairs that contribute to the first view of SCENE.
--listing prints the counted instructions of each kernel, marked as the counts take them.

How it counts. The loop over pairs is the innermost loop that holds MUFU.EX2, one for each pair of a pass. From each
MUFU.EX2 on, alpha is the first FMNMX or saturated operation that its result reaches: alpha cut at alpha_max. What alpha
is computed from, backwards and within the loop, predicates included, is the alpha stage (A), as is the comparison of
alpha with zero and its branch, where there is one (T). What only makes the addresses of its loads is counted apart (+),
since it is shared by a pass. The test is the FSETP or FSET of the stage that the exponent or alpha goes through; a pair
that it rejects does not execute what its predicate guards or its branch skips (k). A warp issues what any of its lanes
executes.
"""
import argparse
import re
import sys

from sass import loops, read_profile, read_sass
from tables.markdown import table
from tables.results import InputError, read

PAPER = {("per-pixel", False): "12", ("half-split", False): "9.625", ("half-split", True): "9.625, 25 % fewer skipped"}
MINI_BATCH = 8  # splats whose shared terms the kernels of HalfSplit compute together
LOADS, TESTS, MOVES = ("LD", "ULD"), ("FSET", "ISETP", "PLOP", "BRA"), ("IMAD.MOV", "MOV", "CS2R")
FORMS = ("per-pixel", "half-split", "float-split", "float-cholesky")


def identify(name):
    """(form, threshold) of a kernel's name, mangled or not; None for kernels that are not counted: those of other
    stages, and those that also write depth or count."""
    name = re.sub(r"\(bool\)([01])", r"Lb\1E", name).replace("true", "Lb1E").replace("false", "Lb0E")
    flags = [flag == "1" for flag in re.findall(r"Lb([01])E", name)]
    extras = re.search(r"Extras\W*E?([0-9])", name)
    if extras:  # of warps; their last flag says who else blends
        flags[-1:] = [extras[1] != "0"]
    if not re.search(r"raster_(per_pixel|half_split|warps)", name) or not flags or flags[-1]:
        return None
    form = ("per-pixel" if "per_pixel" in name else "half-split" if "half_split" in name
            else "float-cholesky" if "Cholesky" in name else "float-split")
    return form, len(flags) > 1 and flags[-2]


class Kernel:
    """What is counted of one kernel."""

    def __init__(self, code):
        self.code = code
        around = [l for l in loops(code) if any("MUFU.EX2" in i.text for i in code[l[0]:l[1] + 1])]
        inner = [l for l in around if not any(o != l and l[0] <= o[0] and o[1] <= l[1] for o in around)]
        if not inner:
            raise ValueError("expected a loop with MUFU.EX2")
        # Unrolled copies and remainders: the one that is executed most, or else the longest.
        self.first, self.last = max(inner, key=lambda l: (max(i.executed for i in code[l[0]:l[1] + 1]), l[1] - l[0]))
        self.around = around
        self.exponentials = [n for n in self.body() if "MUFU.EX2" in code[n].text]
        self.pairs = len(self.exponentials)
        alphas = [self.alpha_after(n) for n in self.exponentials]
        self.stage = self.slice(alphas, addresses=False)
        self.addresses = self.slice(alphas, addresses=True) - self.stage
        self.decisions = self.decisions_on(alphas)
        self.kept_only = self.only_where_kept()

    def body(self):
        return range(self.first, self.last + 1)

    def alpha_after(self, start):
        """Index of the cut that first takes what the exponential at `start` makes."""
        made = set(self.code[start].dests)
        for n in range(start + 1, self.last + 1):
            i = self.code[n]
            if made & set(i.sources):
                if i.opcode == "FMNMX" or i.opcode.endswith(".SAT"):
                    return n
                made |= set(i.dests)
            elif i.guard is None:
                made -= set(i.dests)
        raise ValueError(f"{self.code[start].at:#x}: expected an FMNMX or a saturated operation after "
                         f"{self.code[start].text}")

    def sources_of(self, n, addresses):
        i = self.code[n]
        loads = i.opcode.startswith(("LD", "ULD"))
        return ([] if loads and not addresses else i.sources) + ([i.guard] if i.guard else [])

    def region_of(self, n):
        """Target of the innermost forward branch that skips instruction `n`, else nothing."""
        ends = [i.target for i in self.code[self.first:n] if i.target and i.target > max(i.at, self.code[n].at)]
        return min(ends, default=None)

    def slice(self, roots, addresses):
        """Indices of what `roots` are computed from within the loop, themselves included."""
        found, wanted = set(), [(n, None) for n in roots]
        seen = set()
        while wanted:
            n, register = wanted.pop()
            if register is None:
                if n not in found:
                    found.add(n)
                    wanted += [(n, r) for r in self.sources_of(n, addresses) + (
                        self.code[n].dests if self.code[n].guard else [])]
                continue
            if (n, register) in seen:
                continue
            seen.add((n, register))
            for m in range(n - 1, self.first - 1, -1):
                if register in self.code[m].dests:
                    wanted.append((m, None))
                    # What may not have been executed leaves what was there before.
                    region = self.region_of(m)
                    if self.code[m].guard is None and (region is None or region > self.code[n].at):
                        break
        return found

    def decisions_on(self, alphas):
        """Comparisons of alpha with zero, and the branches that they decide."""
        found = set()
        for alpha in alphas:
            made = set(self.code[alpha].dests)
            for n in range(alpha + 1, min(alpha + 12, self.last)):
                i = self.code[n]
                if i.opcode.startswith("FSETP") and made & set(i.sources) and "RZ" in i.text:
                    branch = next((m for m in range(n + 1, min(n + 6, self.last))
                                   if self.code[m].target and self.code[m].guard in i.dests), None)
                    found |= {n, branch} - {None}
                    break
                if i.guard is None and made & set(i.dests):
                    break
        return found - self.stage

    def only_where_kept(self):
        tests, kept = {}, set()
        end = None  # of what a branch of the test skips
        for n in self.body():
            i = self.code[n]
            if end is not None and i.at >= end:
                end = None
            if end is not None or (i.guard and tests.get(i.guard)):
                kept.add(n)
            if i.target and i.target > i.at and tests.get(i.guard) and end is None:
                end = i.target
            for d in i.dests:
                if "P" in d:
                    tests[d] = i.opcode.startswith("FSETP") and n in self.stage
        return kept & (self.stage | self.decisions)

    def per_pair(self, indices):
        return len(indices) / self.pairs

    def counted(self, kinds):
        """Instructions of the stage a pair whose operation is one of `kinds`."""
        return self.per_pair([n for n in self.stage | self.decisions if self.code[n].opcode.startswith(kinds)])

    def shared_stage(self):
        """Instructions of a thread a splat before the barrier that makes shared terms visible, for a thread of an x
        term and one of a y term: shortest and longest path through them."""
        holding = [l for l in self.around if l[0] <= self.first and self.last <= l[1]]
        for first, last in sorted(holding, key=lambda l: l[1] - l[0]):
            barrier = next((n for n in range(first, last) if self.code[n].opcode.startswith("BAR.SYNC")), None)
            if barrier is None:
                continue
            index = {self.code[n].at: n for n in range(first, barrier + 1)}
            paths = {barrier: {(1, False)}}  # lengths to the barrier, and whether a term is stored on the way
            for n in range(barrier - 1, first - 1, -1):
                i = self.code[n]
                follow = set() if i.target is not None and i.guard is None else {n + 1}
                if index.get(i.target, -1) > n:
                    follow.add(index[i.target])
                paths[n] = {(length + 1, stored or i.opcode.startswith("STS"))
                            for m in follow for length, stored in paths[m]}
            lengths = [length for length, stored in paths[first] if stored]
            return (min(lengths) / MINI_BATCH, max(lengths) / MINI_BATCH) if lengths else None
        return None

    def executed(self, indices=None):
        return sum(self.code[n].executed for n in (range(len(self.code)) if indices is None else indices))

    def listing(self):
        for n in self.body():
            mark = ("A" if n in self.stage else "T" if n in self.decisions else "+" if n in self.addresses else " ")
            print(f"    {mark}{'k' if n in self.kept_only else ' '} {self.code[n].at:04x} {self.code[n].text}")


def number(value):
    return f"{value:.3f}".rstrip("0").rstrip(".")


def raster_word(form, threshold):
    return form if form == "per-pixel" else f"axis-shared-{'threshold-' if threshold else ''}{form}"


STATIC = ("kernel", "shared terms", "loads", "tests", "moves", "arithmetic", "kept", "skipped", "fewer", "addresses",
          "whole loop", "pairs a pass", "paper")
EXECUTED = ("kernel", "warp instructions", "of the alpha stage", "lanes that reach it", "lanes that execute it",
            "contributing pairs", "warp instructions a contributing pair", "contributing lanes")


def static_rows(kernels):
    """Rows of a table with the header STATIC."""
    rows = []
    for (form, threshold), kernel in kernels:
        shared = kernel.shared_stage() if form == "half-split" else None
        terms = shared[1] if shared else 0
        stage = kernel.stage | kernel.decisions
        kept, skipped = terms + kernel.per_pair(stage), terms + kernel.per_pair(stage - kernel.kept_only)
        rows.append([f"`{raster_word(form, threshold)}`",
                     f"{number(shared[0])} to {number(shared[1])}" if shared else "-",
                     number(kernel.counted(LOADS)), number(kernel.counted(TESTS)), number(kernel.counted(MOVES)),
                     number(kernel.per_pair(stage) - kernel.counted(LOADS + TESTS + MOVES)),
                     f"**{number(kept)}**", f"**{number(skipped)}**", f"{100 * (1 - skipped / kept):.0f} %",
                     number(kernel.per_pair(kernel.addresses)), number(len(kernel.body()) / kernel.pairs),
                     str(kernel.pairs), PAPER.get((form, threshold), "-")])
    return rows


def executed_rows(kernels, pairs):
    """Rows of a table with the header EXECUTED; `pairs` holds the contributing pairs of each rasterizer."""
    rows = []
    for (form, threshold), kernel in kernels:
        total = kernel.executed()
        if total == 0:
            continue
        word = raster_word(form, threshold)
        contributing = pairs.get(word)
        everywhere = [n for n, i in enumerate(kernel.code) if "MUFU.EX2" in i.text]
        slots = 32 * kernel.executed(everywhere)
        row = [f"`{word}`", f"{total / 1e6:.1f}"]
        share = 100 * kernel.executed(kernel.stage | kernel.decisions) / total
        row += [f"{share:.0f} %", f"{slots / 1e6:.0f}",
                f"{sum(kernel.code[n].lanes for n in everywhere) / 1e6:.0f}"]
        row += ([f"{contributing / 1e6:.1f}", number(total / contributing), f"{100 * contributing / slots:.0f} %"]
                if contributing else ["-"] * 3)
        rows.append(row)
    return rows


NOTES = """\
Counted from the machine code by `benchmarks/count_instructions.py`, whose head says what is counted. `kept` and
`skipped` are instructions of a thread for one pair: shared terms, loads, tests, moves and arithmetic; `addresses` and
what blends are in `whole loop` alone.

What differs from the paper's counts, and why:

- The paper counts arithmetic alone; loads, tests and moves, a zero for what is skipped, are instructions here too.
- In the kernels of the float terms a lane has two pixels of a row, so that one 16-byte load, which all lanes of a warp
  read at once, serves two pairs, and what depends on the row is computed for both.
- The exponent is kept in base 2 and joined to log2(opacity) by the fused multiply-adds that compute it, in the kernels of
  the float terms: neither the multiplication by log2(e), nor the one by opacity is left, which are two of the three
  instructions that the paper's threshold saves.
- What the threshold could still save is `MUFU.EX2` and the cut at alpha_max. The half kernels leave them out where a lane
  skips, by predicates: a warp issues them where any of its 32 lanes keeps the pair. The float kernels multiply by 0
  instead, which issues less: on Hopper `MUFU` has an eighth of the rate of `FFMA`, but a pipe of its own, which one
  exponential in 14 instructions does not fill. So a skipped pair is no cheaper there. The product also cuts alpha, by
  saturation, since alpha is in units of alpha_max.
- Without the threshold the exponential is evaluated first and alpha is tested: one test either way, so the static
  counts of a kept pair are nearly the same.
- HalfSplit joins halves that must first become floats: a conversion each, on Hopper as `HADD2.F32`.
"""


def read_kernels(paths):
    """[((form, threshold), Kernel)] of the rasterizers' kernels in the files."""
    found = {}
    for path in paths:
        with open(path, encoding="utf-8", errors="replace") as file:
            lines = file.readlines()
        profile = any(line.lstrip('"').startswith("Kernel Name") for line in lines)
        for name, code in (read_profile(lines) if profile else read_sass(lines)).items():
            kind = identify(name)
            if kind and code and (profile or kind not in found):
                try:
                    found[kind] = Kernel(code)
                except ValueError as error:
                    print(f"count_instructions: {raster_word(*kind)}: {error}; not counted", file=sys.stderr)
    return sorted(found.items(), key=lambda item: (FORMS.index(item[0][0]), item[0][1]))


def pairs_of(rows, scene):
    """{rasterizer: pairs that contribute to the first view of a scene}, of rows in the order of the views."""
    pairs = {}
    for row in rows:
        if (row.scene, row.bounds) == (scene, "ellipse") and row.contributing_pairs:
            pairs.setdefault(row.raster, row.contributing_pairs)
    return pairs


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("usage: ")[1].split("\n")[0])
    parser.add_argument("files", nargs="+")
    parser.add_argument("--pairs")
    parser.add_argument("--scene", default="garden")
    parser.add_argument("--listing", action="store_true")
    options = parser.parse_args()
    kernels = read_kernels(options.files)
    if not kernels:
        sys.exit("count_instructions: expected kernels named raster_..., found none")
    pairs = pairs_of(read(options.pairs).rows if options.pairs else [], options.scene)
    print(table(STATIC, static_rows(kernels)), end="\n\n")
    executed = executed_rows(kernels, pairs)
    if executed:
        print("Executed, first view of the scene; millions, of warp instructions, and of lanes at `MUFU.EX2`:\n")
        print(table(EXECUTED, executed), end="\n\n")
    print(NOTES)
    if options.listing:
        for key, kernel in kernels:
            print(f"`{raster_word(*key)}`, a pass of the loop over pairs:\n")
            kernel.listing()
            print()


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        sys.exit(f"count_instructions: {error}")
