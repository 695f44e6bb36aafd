# SPDX-License-Identifier: Apache-2.0
"""What all forms of run.py share: sources with a defect, the outcome of a program, and the report."""
import pathlib
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor

from named import NAMED
from table import MUTANTS as SHOWN

MUTANTS = SHOWN + NAMED

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
# Arguments of the stability tests: without what takes long and looks at no more than the rest.
BRIEFLY = ["--abort-after=1", "--test-case-exclude=*large image*,*wide as images*"]


class Failed(Exception):
    pass


def call(command):
    """Runs a command; what it printed."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed((done.stderr or done.stdout)[-2000:])
    return done.stdout


def run_all(steps, jobs):
    """Calls functions with their arguments, `jobs` at a time; raises the first error."""
    with ThreadPoolExecutor(jobs) as pool:
        for step in [pool.submit(*step) for step in steps]:
            step.result()


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def mutated(mutant):
    text = (ROOT / mutant.file).read_text()
    for old, new in mutant.changes:
        if text.count(old) != 1:
            raise Failed(f"expected once in {mutant.file}: {old}\nfound {text.count(old)} times")
        text = text.replace(old, new)
    return text


def words_of(mutant):
    return "".join(c if c.isalnum() else "_" for c in mutant.name)


def outcome_of(command, environment=None):
    """Runs tests: the outcome and what they said first."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=300, env=environment)
    except subprocess.TimeoutExpired:
        return "killed", "takes more than 300 seconds"
    if done.returncode == 0:
        return "survived", ""
    cases = [line[len("TEST CASE:"):].strip() for line in done.stdout.splitlines() if line.startswith("TEST CASE:")]
    said = cases or done.stderr.splitlines() or ["crashes"]
    return "killed", said[0].removeprefix("mutant: ")


def chosen(options, of_cuda):
    wanted = [m for m in MUTANTS if (m.backend() == "cuda") == of_cuda and (m.quick or not options.quick)
              and m.name.startswith(options.only)]
    if not wanted:
        raise SystemExit(f"mutants: no mutant's name begins with '{options.only}'")
    return wanted


def report(mutants, outcomes, begun):
    """Prints each outcome as it comes, and their counts; whether each mutant is as the table says."""
    counts = {}
    for mutant, (outcome, why) in zip(mutants, outcomes):
        if mutant.equivalent and outcome != "not built":
            outcome, why = ("equivalent", mutant.equivalent) if outcome == "survived" else ("not equivalent", why)
        counts[outcome] = counts.get(outcome, 0) + 1
        print(f"{outcome:10} {mutant.name}{': ' if why else ''}{why}", flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in sorted(counts.items())), end="")
    print(f" in {time.time() - begun:.0f} s")
    return not set(counts) - {"killed", "equivalent"}
