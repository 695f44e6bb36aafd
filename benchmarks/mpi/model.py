#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A model of frames over more ranks than were measured. Its numbers are computed, not measured.

model.py FRAMES.jsonl

FRAMES.jsonl holds lines of frames_over_ranks. For each scene, image size and carrier that was measured on one rank and
on two, prints what the model expects of 4 GPUs from both, beside what was measured of them; and of 8, on one machine
and on two with 100 and 400 Gb/s between them, from one rank and the most that were measured. Of several runs of the
same it takes the quickest.

The model, of N ranks, from runs on one and on M:
- projection takes P / N, and what M ranks took beyond P / M to share splats out and to learn the numbers,
- a strip takes a + b / N; both numbers follow from one rank and M,
- the rank that sends most sends all that it sees, 52 bytes a splat, and sees M / N of what the one of M that saw most
  did: Gaussians beside each other in a file are beside each other in the image, elsewhere than the rank's strip,
- an exchange takes c + bytes / r for that rank; both numbers follow from the runs of a carrier on M ranks that sent
  least and most, and c is 0 where one run is all there is,
- between two machines the link then carries what the rank of two that sent most did,
- images stay with their strips.
"""
import json
import sys

BYTES = 52  # of a splat: shape, depth and colour


def slowest(line, what):
    return max(rank[what] for rank in line["ranks"])


def shrinking(one, more, ranks):
    """a + b / N through both, with neither below 0."""
    b = min(max((one - more) * ranks / (ranks - 1), 0), one)
    return lambda n: one - b + b / n


class Carrier:
    """How long an exchange takes, from all runs on as many ranks."""

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
    """Of more ranks than `base`, a run on two or more by `carrier`."""

    def __init__(self, one, two, base, carrier):
        ranks, projection = len(base["ranks"]), slowest(one, "project_ms")
        sharing = max(slowest(base, "project_ms") - projection / ranks, 0)
        self.project = lambda n: projection / n + sharing
        self.strip = shrinking(slowest(one, "strip_ms"), slowest(base, "strip_ms"), ranks)
        self.seen = slowest(base, "visible") * ranks
        self.between_machines = BYTES * slowest(two, "sent")
        self.carrier = carrier

    def sent_bytes(self, n):
        """Of the rank that sends most."""
        return BYTES * self.seen / n

    def ms(self, n, gigabits=None):
        between = self.between_machines / (gigabits * 1e9 / 8 / 1e3) if gigabits else 0
        return self.project(n) + self.strip(n) + self.carrier.ms(self.sent_bytes(n)) + between


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
    runs_of = {}  # of a carrier on a number of ranks
    for carriers in measured.values():
        for carrier, runs in carriers.items():
            for ranks, run in runs.items():
                runs_of.setdefault((carrier, ranks), []).append(run)
    print("Computed by a model from measurements, but for what is measured.\n")
    print("| scene | size | by | 1, measured | 2, measured | 4, by the model | 4, measured | 8 | 2 x 4, 100 Gb/s "
          "| 2 x 4, 400 Gb/s | MB of most of 8 |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for (scene, width, height), carriers in measured.items():
        one = carriers.get("", {}).get(1)
        for carrier, runs in carriers.items():
            if not one or 2 not in runs:
                continue
            of_two, of_most = (Model(one, runs[2], runs[ranks], Carrier(runs_of[carrier, ranks]))
                               for ranks in (2, 4 if 4 in runs else 2))
            times = [one["ms"], runs[2]["ms"], of_two.ms(4), runs[4]["ms"] if 4 in runs else None, of_most.ms(8),
                     of_most.ms(8, 100), of_most.ms(8, 400)]
            cells = [scene.rsplit("/", 1)[-1], f"{width}x{height}", carrier]
            cells += ["-" if ms is None else f"{ms:.2f} ms" for ms in times] + [f"{of_most.sent_bytes(8) / 1e6:.1f}"]
            print("| " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
