#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kills ranks of running programs at random points: the rest must stop, say so, and leave no part of a file.

Most are killed while they write images, a few milliseconds after a random number of images is there; the others at
random times, which are mostly those of a start.

kill_ranks.py LAUNCH SWIFTGS FRAMES FOLDER TIMES [SEED]

LAUNCH starts ranks as mpirun does. SWIFTGS is the command-line tool, whose ranks share views; FRAMES is
frames_in_a_loop, whose ranks share each frame. FOLDER is made anew and holds what they write.
"""
import concurrent.futures
import contextlib
import dataclasses
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

from ranks_of_run import check_files, ranks_of, require, running, skip_without_unnamed_files

WORKERS = ("views", "views", "frames")  # each kills its share of the times, side by side
IMAGES = 25
BY_TIME = 0.15  # share of the kills
FEW_MILLISECONDS = 0.01
SECONDS_TO_STOP = 10  # the machine may be busy
# Open MPI 4 and 5 would wait a second from asking ranks to end to killing them.
AT_ONCE = {f"{program}_MCA_odls_base_sigkill_timeout": "0" for program in ("OMPI", "PRTE")}
# If a rank dies while it connects to its launcher, that of Open MPI 4.1 may stop all ranks and then wait for itself for
# ever. So few launchers may do so; such a run is none of the times.
MOST_STUCK_LAUNCHERS = 3


@dataclasses.dataclass
class Work:
    launch: str
    command: list
    longest: float = 0  # seconds that it takes when nobody disturbs it

    def running(self, folder):
        return running(self.launch, self.command, folder, **AT_ONCE)

    def check(self, folder, finished):
        check_files(folder, IMAGES)
        if finished:
            require(images_in(folder) == IMAGES, "a run that ended well left out images")


@dataclasses.dataclass
class Tally:
    runs: int = 0
    killed: int = 0  # runs that were cut by it
    between: int = 0  # of these, how many left some images and not all
    slowest: float = 0  # that the rest went on. @units{seconds}
    stuck: int = 0  # launchers


class StuckLauncher(Exception):
    """All ranks were gone, and the launcher was not."""


def images_in(folder):
    images = folder / "renders"  # of the tool; FRAMES writes into the folder itself
    return sum(name.endswith(".png") for name in os.listdir(images if images.is_dir() else folder))


def await_moment(work, folder, started, rng):
    """Returns at a random point of a run, and says which."""
    if rng.random() < BY_TIME:
        delay = rng.uniform(0, 0.9 * work.longest)
        time.sleep(delay)
        return f"at {delay:.3f} s"
    images = rng.randint(0, IMAGES)
    while images_in(folder) < images and started.poll() is None:
        time.sleep(0.002)
    time.sleep(rng.uniform(0, FEW_MILLISECONDS))
    return f"after {images} images"


def run_once(work, folder, rng, tally):
    program = work.command[0]
    with work.running(folder) as started:
        moment = await_moment(work, folder, started, rng)
        killed = False
        while not killed and started.poll() is None:
            ranks = ranks_of(program, folder)
            if not ranks:  # the launcher has not started them yet
                time.sleep(0.01)
                continue
            with contextlib.suppress(ProcessLookupError):
                os.kill(rng.choice(ranks), signal.SIGKILL)
                killed = True
        at = time.monotonic()
        try:
            code = started.wait(timeout=SECONDS_TO_STOP)
        except subprocess.TimeoutExpired:
            left = ranks_of(program, folder)
            require(not left, f"{len(left)} ranks went on for {SECONDS_TO_STOP} s after one was killed {moment}")
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
            tally.killed += 1
            tally.between += 0 < images_in(folder) < IMAGES
            tally.slowest = max(tally.slowest, stopped)
        work.check(folder, code == 0)


def kill_in_turn(work, folder, rng, times):
    tally = Tally()
    while tally.killed < times and tally.runs < 2 * times:
        tally.runs += 1
        try:
            run_once(work, folder, rng, tally)
        except StuckLauncher:
            tally.stuck += 1
    return tally


def main():
    launch, tool, frames = map(os.path.realpath, sys.argv[1:4])
    folder, times = pathlib.Path(sys.argv[4]).resolve(), int(sys.argv[5])
    skip_without_unnamed_files(folder)
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
    tallies = [each.result() for each in done]
    for name, tally in zip(WORKERS, tallies):
        print(f"{name}: killed a rank in {tally.killed} of {tally.runs} runs of {kinds[name].longest:.2f} s, "
              f"{tally.between} of which left some images; the rest stopped within {tally.slowest:.2f} s; "
              f"{tally.stuck} launchers went on without ranks")
    total, between, stuck = (sum(getattr(tally, name) for tally in tallies) for name in ("killed", "between", "stuck"))
    require(total == times, f"a rank was killed {total} times alone")
    require(2 * between >= times, f"a rank was killed between images {between} times alone")
    require(stuck <= MOST_STUCK_LAUNCHERS, f"{stuck} launchers went on without ranks")
    shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
