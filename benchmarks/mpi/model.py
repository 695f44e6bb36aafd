#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A model of frames over more ranks than were measured. Its numbers are computed, not measured.

model.py FRAMES.jsonl

FRAMES.jsonl holds lines of frames_over_ranks. For each scene, image size and carrier that was measured on one rank and
on two, prints what the model expects of 4 and 8 GPUs of one machine, and of as many on two machines with 100 and
400 Gb/s between them. Of several such runs it takes the quickest.

The model:
- projection takes P / N, and what two ranks took beyond P / 2 to share splats out and to learn the numbers,
- a strip takes a + b / N; both numbers follow from one rank and two,
- each border between strips is crossed by as many splats as the one of two strips; D = V (1 + (N - 1) q) are drawn,
- of those, (N - 1) / N times what two ranks measured go to another rank, 52 bytes each,
- an exchange takes c + bytes / r for the rank that sends most; both numbers follow from the two-rank runs of a carrier
  that sent least and most, and c is 0 where one run is all there is,
- between machines the link carries what ranks of one send to the other, all through one link, after that,
- images stay with their strips.
"""
import json
import sys

BYTES = 52  # of a splat: shape, depth and colour


def slowest(line, what):
    return max(rank[what] for rank in line["ranks"])


def sum_of(line, what):
    return sum(rank[what] for rank in line["ranks"])


def shrinking(one, two):
    """a + b / N through both, with neither below 0."""
    b = min(max(2 * (one - two), 0), one)
    return lambda n: one - b + b / n


class Carrier:
    """How long an exchange takes, from all runs on two ranks."""

    def __init__(self, runs):
        def point(line):
            rest = line["ms"] - slowest(line, "project_ms") - slowest(line, "strip_ms")
            return BYTES * slowest(line, "sent"), max(rest, 1e-3)
        points = sorted(point(run) for run in runs)
        (least, short), (most, long) = points[0], points[-1]
        self.rate = (most - least) / (long - short) if most > least and long > short else most / long  # bytes/ms
        self.latency = max(short - least / self.rate, 0)

    def ms(self, sent_bytes):
        return self.latency + sent_bytes / self.rate


class Model:
    def __init__(self, one, two, carrier):
        projection = slowest(one, "project_ms")
        sharing = max(slowest(two, "project_ms") - projection / 2, 0)
        self.project = lambda n: projection / n + sharing
        self.strip = shrinking(slowest(one, "strip_ms"), slowest(two, "strip_ms"))
        self.visible = sum_of(one, "drawn")
        self.crossing = max(sum_of(two, "drawn") / max(self.visible, 1) - 1, 0)
        self.away = sum_of(two, "sent") / max(sum_of(two, "drawn") / 2, 1)
        self.uneven = slowest(two, "sent") / max(sum_of(two, "sent") / 2, 1)
        self.carrier = carrier

    def sent_bytes(self, n):
        """Of the rank that sends most."""
        drawn = self.visible * (1 + (n - 1) * self.crossing)
        return BYTES * self.away * drawn * (n - 1) / n / n * self.uneven

    def ms(self, n, gigabits=None):
        exchange = self.carrier.ms(self.sent_bytes(n)) if n > 1 else 0
        if gigabits:
            to_other_machine = self.sent_bytes(n) * (n / 2) / (n - 1)
            exchange += n / 2 * to_other_machine / (gigabits * 1e9 / 8 / 1e3)
        return self.project(n) + self.strip(n) + exchange


def quickest_runs(lines):
    """{(scene, width, height): {carrier: {ranks: line}}}; one rank, which sends nothing, has the carrier ''."""
    measured = {}
    for line in lines:
        size, ranks = (line["scene"], line["width"], line["height"]), len(line["ranks"])
        runs = measured.setdefault(size, {}).setdefault(line["carrier"] if ranks > 1 else "", {})
        if ranks not in runs or line["ms"] < runs[ranks]["ms"]:
            runs[ranks] = line
    return measured


def main():
    with open(sys.argv[1], encoding="utf-8") as lines:
        measured = quickest_runs(json.loads(text) for text in lines)
    on_two = {}
    for carriers in measured.values():
        for carrier, runs in carriers.items():
            if carrier and 2 in runs:
                on_two.setdefault(carrier, []).append(runs[2])
    print("Computed by a model from measurements on one rank and on two.\n")
    print("| scene | size | by | 1, measured | 2, measured | 4 | 8 | 2 x 4, 100 Gb/s | 2 x 4, 400 Gb/s "
          "| MB a rank of 8 |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for (scene, width, height), carriers in measured.items():
        one = carriers.get("", {}).get(1)
        for carrier, runs in carriers.items():
            if not one or 2 not in runs:
                continue
            model = Model(one, runs[2], Carrier(on_two[carrier]))
            name = scene.rsplit("/", 1)[-1]
            times = [one["ms"], runs[2]["ms"], model.ms(4), model.ms(8), model.ms(8, 100), model.ms(8, 400)]
            cells = [f"{ms:.2f} ms" for ms in times] + [f"{model.sent_bytes(8) / 1e6:.1f}"]
            print(f"| {name} | {width}x{height} | {carrier} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
