#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A model of frames over more ranks than were measured. Its numbers are computed, not measured.

model.py FRAMES.jsonl

FRAMES.jsonl holds lines of frames_over_ranks. For each scene, image size and carrier that was measured on one rank and
on two, prints what the model expects of 4 and 8 GPUs of one machine, and of as many on two machines with 100 and
400 Gb/s between them. Of several such runs it takes the quickest.

The model:
- projection and a band take a + b / N; both numbers follow from one rank and two,
- each border between bands is crossed by as many splats as the one of two bands; D = V (1 + (N - 1) q) are drawn,
- of those, (N - 1) / N times what two ranks measured go to another rank, 52 bytes each,
- a rank sends and receives as fast as one of two did, with copies to the host and back where the host carries,
- between machines the link carries what ranks of one send to the other, all through one link, after that,
- images stay with their bands.
"""
import json
import sys

BYTES = 52  # of a splat: shape, depth and colour


def parts(line):
    ranks = line["ranks"]
    return {
        "project": max(rank["project_ms"] for rank in ranks),
        "band": max(rank["band_ms"] for rank in ranks),
        "drawn": sum(rank["drawn"] for rank in ranks),
        "sent": sum(rank["sent"] for rank in ranks),
        "ms": line["ms"],
    }


def shrinking(one, two):
    """a + b / N through both, with neither below 0."""
    b = min(max(2 * (one - two), 0), one)
    return lambda n: one - b + b / n


class Model:
    def __init__(self, one, two):
        one, two = parts(one), parts(two)
        self.project, self.band = shrinking(one["project"], two["project"]), shrinking(one["band"], two["band"])
        self.visible = one["drawn"]
        self.crossing = max(two["drawn"] / max(self.visible, 1) - 1, 0)
        self.away = two["sent"] / max(two["drawn"] / 2, 1)
        exchange = max(two["ms"] - two["project"] - two["band"], 1e-3)
        self.rate = BYTES * two["sent"] / 2 / exchange  # of a rank @units{bytes/ms}

    def sent_bytes(self, n):
        """Of one rank."""
        drawn = self.visible * (1 + (n - 1) * self.crossing)
        return BYTES * self.away * drawn * (n - 1) / n / n

    def ms(self, n, gigabits=None):
        exchange = self.sent_bytes(n) / self.rate if n > 1 else 0
        if gigabits:
            to_other_machine = self.sent_bytes(n) * (n / 2) / (n - 1)
            exchange += n / 2 * to_other_machine / (gigabits * 1e9 / 8 / 1e3)
        return self.project(n) + self.band(n) + exchange


def main():
    measured = {}
    with open(sys.argv[1], encoding="utf-8") as lines:
        for text in lines:
            line = json.loads(text)
            size, ranks = (line["scene"], line["width"], line["height"]), len(line["ranks"])
            # One rank sends nothing, and stands beside every carrier.
            runs = measured.setdefault(size, {}).setdefault(line["carrier"] if ranks > 1 else "", {})
            if ranks not in runs or line["ms"] < runs[ranks]["ms"]:
                runs[ranks] = line
    print("Computed by a model from measurements on one rank and on two.\n")
    print("| scene | size | by | 1, measured | 2, measured | 4 | 8 | 2 x 4, 100 Gb/s | 2 x 4, 400 Gb/s "
          "| MB a rank of 8 |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for (scene, width, height), carriers in measured.items():
        one = carriers.get("", {}).get(1)
        for carrier, runs in carriers.items():
            if not one or 2 not in runs:
                continue
            model = Model(one, runs[2])
            name = scene.rsplit("/", 1)[-1]
            times = [one["ms"], runs[2]["ms"], model.ms(4), model.ms(8), model.ms(8, 100), model.ms(8, 400)]
            cells = [f"{ms:.2f} ms" for ms in times] + [f"{model.sent_bytes(8) / 1e6:.1f}"]
            print(f"| {name} | {width}x{height} | {carrier} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
