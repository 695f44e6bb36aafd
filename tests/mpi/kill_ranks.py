#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kills ranks of a running command at random points: the rest must stop, say so, and leave no part of a file.

kill_ranks.py LAUNCH SWIFTGS FOLDER TIMES [SEED]

LAUNCH starts ranks as mpirun does, SWIFTGS is the command-line tool. FOLDER is made anew and holds what the command
writes.
"""
import concurrent.futures
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

RANKS = 3
WORKERS = 3
VIEWS = 25
SECONDS_TO_STOP = 10  # MPI asks politely first, and the machine may be busy


def ranks_of(tool, folder):
    """Process numbers of the tool that works in `folder`."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            if os.readlink(entry / "exe") == tool and os.readlink(entry / "cwd") == folder:
                found.append(int(entry.name))
        except OSError:  # gone, or another user's
            pass
    return sorted(found)


def require(holds, what):
    if not holds:
        raise SystemExit(f"kill_ranks: {what}")


def check_files(folder, finished):
    """Every file is whole, and has the name that it was to have."""
    for path in folder.rglob("*"):
        if path.is_dir():
            continue
        content = path.read_bytes()
        if path.suffix == ".png":
            require(content.endswith(b"IEND\xae\x42\x60\x82"), f"{path} is no whole image")
        elif path.name == "results.json":
            require(len(json.loads(content)["rows"]) == VIEWS, f"{path} does not hold all rows")
        else:
            require(path.name in ("stdout.txt", "stderr.txt"), f"{path} was left behind")
    if finished:
        require(len(list(folder.glob("renders/*.png"))) == VIEWS, "a run that ended well left out images")


def start(launch, tool, folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    command = ["render", "builtin:2000", "--views", "all", "--scale", "0.15", "--json", "results.json"]
    with open(folder / "stdout.txt", "wb") as out, open(folder / "stderr.txt", "wb") as err:
        return subprocess.Popen([launch, "-n", str(RANKS), tool, *command], cwd=folder, stdout=out, stderr=err)


def run_once(launch, tool, folder, rng, longest):
    """Whether a rank was killed in time, and how long the rest went on. @units{seconds}"""
    started = start(launch, tool, folder)
    delay = rng.uniform(0, 0.9 * longest)
    time.sleep(delay)
    killed = False
    while not killed and started.poll() is None:
        ranks = ranks_of(tool, str(folder))  # none before the launcher has started them
        try:
            if ranks:
                os.kill(rng.choice(ranks), signal.SIGKILL)
                killed = True
        except ProcessLookupError:
            pass
    at = time.monotonic()
    try:
        code = started.wait(timeout=60)
    except subprocess.TimeoutExpired:
        for rank in ranks_of(tool, str(folder)):
            os.kill(rank, signal.SIGKILL)
        started.kill()
        raise SystemExit(f"kill_ranks: the rest went on for a minute after a rank was killed at {delay:.3f} s")
    while ranks_of(tool, str(folder)) and time.monotonic() - at < SECONDS_TO_STOP:
        time.sleep(0.01)
    stopped = time.monotonic() - at
    if code != 0:
        require(killed, f"nothing was killed, and the command ended with {code}")
        require(stopped < SECONDS_TO_STOP, f"the rest went on for {stopped:.1f} s")
        require((folder / "stderr.txt").read_bytes(), "MPI did not say that a rank was killed")
    check_files(folder, code == 0)
    return code != 0, stopped


def kill_in_turn(launch, tool, folder, rng, longest, times):
    """How often a rank was killed, in how many runs, and how long the rest went on at most."""
    cut, runs, slowest = 0, 0, 0.0
    while cut < times and runs < 2 * times:
        failed, stopped = run_once(launch, tool, folder, rng, longest)
        cut, runs = cut + failed, runs + 1
        slowest = max(slowest, stopped if failed else 0)
    return cut, runs, slowest


def main():
    launch, tool = os.path.realpath(sys.argv[1]), os.path.realpath(sys.argv[2])
    folder, times = pathlib.Path(sys.argv[3]).resolve(), int(sys.argv[4])
    rng = random.Random(int(sys.argv[5]) if len(sys.argv) > 5 else 1)
    # As long as the command takes when nobody disturbs it.
    begun = time.monotonic()
    require(start(launch, tool, folder).wait() == 0, "the command fails by itself")
    longest = time.monotonic() - begun
    check_files(folder, True)
    # Launchers wait more than they work: several go side by side.
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as pool:
        done = [pool.submit(kill_in_turn, launch, tool, folder / str(worker), random.Random(rng.random()), longest,
                            times * (worker + 1) // WORKERS - times * worker // WORKERS) for worker in range(WORKERS)]
    cut, runs, slowest = map(list, zip(*(each.result() for each in done)))
    cut, runs, slowest = sum(cut), sum(runs), max(slowest)
    require(cut == times, f"a rank was killed in {cut} of {runs} runs alone")
    print(f"killed a rank in {cut} of {runs} runs of {longest:.2f} s; the rest stopped within {slowest:.2f} s")
    shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
