# SPDX-License-Identifier: Apache-2.0
"""What tests that stop ranks share: how a run starts and ends, its processes, and whether its files are whole."""
import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile

RANKS = 3


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
def running(launch, command, folder, apart=None, **environment):
    """Runs `command` on ranks in `folder`, made anew; the last of them in the folder `apart` of it if that is named.

    `environment` comes beside that of the test. Yields the launcher. What still runs after the block is ended, however
    the block was left.
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
                                   env=dict(os.environ, TMPDIR=session, **environment))
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
