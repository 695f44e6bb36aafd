#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Has a rank throw while others work, on cores that are busy: all must be gone within a second, with one line.

throw_in_ranks.py LAUNCH SWIFTGS FRAMES FOLDER TIMES

LAUNCH starts ranks as mpirun does. A rank of FRAMES, which is frames_in_a_loop, throws between frames while the others
wait for its splats. A rank of SWIFTGS, the command-line tool, loses the folder for its images while the others draw.
"""
import contextlib
import json
import os
import pathlib
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time

RANKS = 3
SECONDS = 1.0
BUSY = 2
VIEWS = 2000  # small ones: the next image is never far
FRAMES = 10_000  # more than are drawn before one throws
# Ends with the process that it is told of, even one that is killed.
LOOP = "import os, sys\nwhile os.getppid() == int(sys.argv[1]): pass"


def require(holds, what):
    if not holds:
        raise SystemExit(f"ranks: {what}")


def skip_without_unnamed_files(folder):
    """Ends a test that what is stopped leaves nothing, where unfinished files have names."""
    folder.mkdir(parents=True, exist_ok=True)
    try:
        os.close(os.open(folder, os.O_TMPFILE | os.O_WRONLY))
    except OSError as error:
        print(f"skipped: {folder}: this file system has no files without a name: {error.strerror}")
        sys.exit(77)


@contextlib.contextmanager
def running(launch, command, folder, apart=None):
    """Runs `command` on ranks in `folder`, made anew; the last of them in the folder `apart` of it if that is named.

    Yields the launcher. What still runs after the block is ended, however the block was left.
    """
    shutil.rmtree(folder, ignore_errors=True)
    (folder / (apart or "")).mkdir(parents=True)
    arguments = ["-n", str(RANKS), *command]
    if apart:
        arguments = ["-n", str(RANKS - 1), *command, ":", "-n", "1", "-wdir", apart, *command]
    # Launchers that start at once trip over each other's folders for sessions.
    with (open(folder / "stdout.txt", "wb") as out, open(folder / "stderr.txt", "wb") as err,
          tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as session):
        started = subprocess.Popen([launch, *arguments], cwd=folder, stdout=out, stderr=err,
                                   env=dict(os.environ, TMPDIR=session))
        try:
            yield started
        finally:
            started.terminate()
            try:
                started.wait(timeout=10)
            except subprocess.TimeoutExpired:
                started.kill()
                started.wait()
            for rank in ranks_of(command[0], folder):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(rank, signal.SIGKILL)


def ranks_of(program, folder):
    """Process numbers of the program that works in `folder`, or in one in it."""
    found, folders = [], (folder, *folder.glob("*/"))
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            if os.readlink(entry / "exe") == program and pathlib.Path(os.readlink(entry / "cwd")) in folders:
                found.append(int(entry.name))
        except OSError:  # gone, or another user's
            pass
    return sorted(found)


def check_files(folder, rows, others=()):
    """Every file is whole, and has the name that it was to have."""
    for path in folder.rglob("*"):
        if path.is_dir():
            continue
        if path.suffix == ".png":
            require(path.read_bytes().endswith(b"IEND\xae\x42\x60\x82"), f"{path} is no whole image")
        elif path.suffix == ".ply":
            head, _, rows_of_floats = path.read_bytes().partition(b"end_header\n")
            counts = [int(line.split()[2]) for line in head.split(b"\n") if line.startswith(b"element vertex ")]
            sizes = [4 * count * head.count(b"property float ") for count in counts]
            require([len(rows_of_floats)] == sizes, f"{path} is no whole scene")
        elif path.name == "results.json":
            require(len(json.loads(path.read_bytes())["rows"]) == rows, f"{path} does not hold all rows")
        else:
            require(path.name in ("stdout.txt", "stderr.txt", *others), f"{path} was left behind")


@contextlib.contextmanager
def busy_cores():
    busy = [subprocess.Popen([sys.executable, "-c", LOOP, str(os.getpid())]) for _ in range(BUSY)]
    try:
        yield
    finally:
        for each in busy:
            each.kill()
            each.wait()


def wait_for(what, holds, started):
    until = time.monotonic() + 60
    while not holds():
        require(time.monotonic() < until and started.poll() is None, f"{what} did not happen")
        time.sleep(0.01)


def watch(started, program, folder):
    """Handles of the processes of all ranks."""
    wait_for("the start of all ranks", lambda: len(ranks_of(program, folder)) == RANKS, started)
    return [os.pidfd_open(rank) for rank in ranks_of(program, folder)]


def await_end(handles):
    """When the last of the processes was gone. @units{seconds}"""
    left = set(handles)
    poll = select.poll()
    for handle in handles:
        poll.register(handle, select.POLLIN)
    until = time.monotonic() + 60
    while left:
        require(time.monotonic() < until, "ranks went on for a minute after one threw")
        for handle, _ in poll.poll(100):
            poll.unregister(handle)
            left.discard(handle)
    at = time.monotonic()
    for handle in handles:
        os.close(handle)
    return at


def finish(started, folder, line):
    require(started.wait(timeout=60) == 1, f"the launcher ended with {started.returncode}, expected 1")
    said = (folder / "stderr.txt").read_text().count(": rank ")
    require(line in (folder / "stderr.txt").read_text(), f"standard error does not hold '{line}'")
    require(said == 1, f"standard error holds {said} lines of ranks, expected one")


def throw_between_frames(launch, program, folder):
    with running(launch, [program, str(FRAMES), "1"], folder) as started:
        wait_for("the first frame", lambda: (folder / "frame-0.png").exists(), started)
        handles = watch(started, program, folder)
        (folder / "throw").touch()
        gone = await_end(handles)
        finish(started, folder, "frames_in_a_loop: rank 1 of 3: thrown by a test\n")
    check_files(folder, 0, ("throw", "thrown.txt"))
    return gone - 1e-9 * int((folder / "thrown.txt").read_text())


def lose_a_folder(launch, program, folder):
    camera = {"width": 32, "height": 24, "fx": 30, "fy": 30, "position": [0, 0, -4],
              "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}
    folder.parent.mkdir(parents=True, exist_ok=True)
    cameras = folder.parent / "cameras.json"
    cameras.write_text(json.dumps([{"id": k, "img_name": str(k), **camera} for k in range(VIEWS)]))
    images = folder / "last" / "renders"
    command = [program, *f"render builtin:500 --cameras {cameras} --views all --json results.json".split()]
    with running(launch, command, folder, "last") as started:
        wait_for("the first image of the last rank", (images / f"{RANKS - 1}.png").exists, started)
        handles = watch(started, program, folder)
        begun = time.monotonic()  # a little before the next image finds it gone
        images.rename(folder / "gone")
        gone = await_end(handles)
        require(not (folder / "results.json").exists(), "a run that failed has results")
        finish(started, folder, ": No such file or directory\n")
    check_files(folder, VIEWS)
    return gone - begun


def main():
    launch, tool, frames = map(os.path.realpath, sys.argv[1:4])
    folder, times = pathlib.Path(sys.argv[4]).resolve(), int(sys.argv[5])
    skip_without_unnamed_files(folder)
    with busy_cores():
        for name, run, program in (("frames", throw_between_frames, frames), ("views", lose_a_folder, tool)):
            seconds = [run(launch, program, folder / name) for _ in range(times)]
            print(f"{name}: all ranks were gone after " + ", ".join(f"{each:.2f} s" for each in seconds))
            require(max(seconds) < SECONDS, f"a rank of {name} went on for {max(seconds):.2f} s after another threw")
    shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
