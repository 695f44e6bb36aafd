#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kills ranks of running programs at random points: the rest must stop, say so, and leave no part of a file.

kill_ranks.py LAUNCH SWIFTGS FRAMES FOLDER TIMES [SEED]

LAUNCH starts ranks as mpirun does. SWIFTGS is the command-line tool, whose ranks share views; FRAMES is
frames_in_a_loop, whose ranks share each frame. FOLDER is made anew and holds what they write.
"""
import concurrent.futures
import dataclasses
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

from ranks_of_run import check_files, ranks_of, require, running

WORKERS = ("views", "views", "frames")  # each kills its share of the times, side by side
IMAGES = 25
SECONDS_TO_STOP = 10  # MPI asks politely first, and the machine may be busy
# If a rank dies while it connects to its launcher, that of Open MPI 4.1 may stop all ranks and then wait for itself for
# ever. So few launchers may do so; such a run is none of the times.
MOST_STUCK_LAUNCHERS = 3


@dataclasses.dataclass
class Work:
    launch: str
    command: list
    longest: float = 0  # seconds that it takes when nobody disturbs it

    def running(self, folder):
        return running(self.launch, self.command, folder)

    def check(self, folder, finished):
        check_files(folder, IMAGES)
        if finished:
            require(len(list(folder.rglob("*.png"))) == IMAGES, "a run that ended well left out images")


class StuckLauncher(Exception):
    """All ranks were gone, and the launcher was not."""


def run_once(work, folder, rng):
    """Whether a rank was killed in time, and how long the rest went on. @units{seconds}"""
    program = work.command[0]
    with work.running(folder) as started:
        delay = rng.uniform(0, 0.9 * work.longest)
        time.sleep(delay)
        killed = False
        while not killed and started.poll() is None:
            ranks = ranks_of(program, folder)  # none before the launcher has started them
            try:
                if ranks:
                    os.kill(rng.choice(ranks), signal.SIGKILL)
                    killed = True
            except ProcessLookupError:
                pass
        at = time.monotonic()
        try:
            code = started.wait(timeout=SECONDS_TO_STOP)
        except subprocess.TimeoutExpired:
            left = ranks_of(program, folder)
            require(not left, f"{len(left)} ranks went on for {SECONDS_TO_STOP} s after one was killed at {delay:.3f} s")
            started.kill()
            work.check(folder, False)
            raise StuckLauncher from None
        while ranks_of(program, folder) and time.monotonic() - at < SECONDS_TO_STOP:
            time.sleep(0.01)
        stopped = time.monotonic() - at
        if code != 0:
            require(killed, f"nothing was killed, and the command ended with {code}")
            require(stopped < SECONDS_TO_STOP, f"the rest went on for {stopped:.1f} s")
            require((folder / "stderr.txt").read_bytes(), "MPI did not say that a rank was killed")
        work.check(folder, code == 0)
        return code != 0, stopped


def kill_in_turn(work, folder, rng, times):
    """How often a rank was killed, in how many runs, how long the rest went on at most, and stuck launchers."""
    cut, runs, slowest, stuck = 0, 0, 0.0, 0
    while cut < times and runs < 2 * times:
        runs += 1
        try:
            failed, stopped = run_once(work, folder, rng)
        except StuckLauncher:
            stuck += 1
            continue
        cut += failed
        slowest = max(slowest, stopped if failed else 0)
    return cut, runs, slowest, stuck


def main():
    launch, tool, frames = map(os.path.realpath, sys.argv[1:4])
    folder, times = pathlib.Path(sys.argv[4]).resolve(), int(sys.argv[5])
    rng = random.Random(int(sys.argv[6]) if len(sys.argv) > 6 else 1)
    views = "render builtin:2000 --views all --scale 0.15 --json results.json".split()
    kinds = {"views": Work(launch, [tool, *views]), "frames": Work(launch, [frames, str(IMAGES)])}
    for name, work in kinds.items():
        begun = time.monotonic()
        with work.running(folder) as started:
            require(started.wait() == 0, f"the run of {name} fails by itself")
        work.longest = time.monotonic() - begun
        work.check(folder, True)
    # Launchers wait more than they work: several go side by side.
    count = len(WORKERS)
    with concurrent.futures.ThreadPoolExecutor(count) as pool:
        done = [pool.submit(kill_in_turn, kinds[name], folder / str(k), random.Random(rng.random()),
                            times * (k + 1) // count - times * k // count) for k, name in enumerate(WORKERS)]
    for name, each in zip(WORKERS, done):
        cut, runs, slowest, stuck = each.result()
        print(f"{name}: killed a rank in {cut} of {runs} runs of {kinds[name].longest:.2f} s; "
              f"the rest stopped within {slowest:.2f} s; {stuck} launchers went on without ranks")
    total, stuck = (sum(each.result()[k] for each in done) for k in (0, 3))
    require(total == times, f"a rank was killed {total} times alone")
    require(stuck <= MOST_STUCK_LAUNCHERS, f"{stuck} launchers went on without ranks")
    shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
