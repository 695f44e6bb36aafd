# SPDX-License-Identifier: Apache-2.0
"""The clauses of the conformance set, and what its judge says of renderers: each in a row, and the viewers clause by
clause."""
from collections import Counter
import json
import pathlib
from statistics import median

from tables.markdown import decibel, table
from tables.results import Row, read_format

FILES = ("swiftgs.json", "rivals.json", "viewers.json")
VERDICTS = {"r": "right", "d": "differs", "e": "differs", "n": "not drawn"}
MANIFEST = pathlib.Path(__file__).resolve().parents[2] / "tests/conformance/set/manifest.json"


def judged(source, folder, names=FILES):
    """{(renderer, settings): a row for each clause}, and where they were drawn."""
    found, machines = {}, []
    for path in [source.path(folder, name) for name in names if source.has(folder, name)]:
        file = source.once(lambda path: read_format(path, "swiftgs-conformance"), path)
        machines.append(file["machine"])
        nothing = [None] * len(file["clauses"])
        for row in file["rows"]:
            found[row["renderer"], row["settings"]] = [
                Row({"clause": clause, "verdict": VERDICTS[letter], "explained": letter == "e", "db": db,
                     "nearest": None if place is None else file["names"][place], "nearest_db": nearest_db})
                for clause, letter, db, place, nearest_db in zip(
                    file["clauses"], row["verdicts"], row["db"], row.get("nearest", nothing),
                    row.get("nearest_db", nothing))]
    return found, machines


def conformance(source, folder):
    """How many clauses of the set each renderer draws right, and what the others have in common."""
    found, machines = judged(source, folder)
    lines = []
    for (renderer, settings), rows in found.items():
        verdicts = Counter(row.verdict for row in rows)
        named = Counter(name for row in rows if row.nearest for name in row.nearest.split(" + "))
        lines.append([renderer, settings, ", ".join(f"{name} ({count})" for name, count in named.most_common(3)) or "-",
                      str(verdicts["right"]), str(verdicts["differs"]), str(sum(bool(row.explained) for row in rows)),
                      str(verdicts["not drawn"]), decibel(median(row.db for row in rows if row.db is not None))])
    where = dict.fromkeys(f"{about['gpu']}, {about['date']}" for about in machines)
    return (f"{'; '.join(where)}:\n\n" + table(
        ["renderer", "settings", "named most, in how many clauses", "right", "differ", "explained", "not drawn",
         "median dB"], lines, words=3))


def conformance_clauses(source, folder):
    """Each clause in each viewer at its best settings."""
    found, _ = judged(source, folder, FILES[2:])
    best = {renderer: {row.clause: row for row in found[renderer, settings]} for renderer, settings in sorted(
        found, key=lambda key: key[1] == "best")}

    def cell(row):
        if row.verdict != "differs":
            return row.verdict
        nearest = decibel(row.nearest_db) + (", every pixel" if row.explained else "")
        return decibel(row.db) + (f": {row.nearest} ({nearest})" if row.nearest else "")
    clauses = dict.fromkeys(clause for rows in best.values() for clause in rows)
    return table(["clause", *best], [[clause, *(cell(rows[clause]) for rows in best.values())] for clause in clauses],
                 words=1 + len(best))


def conformance_set(_source):
    """What each clause asks, and which texts leave it open."""
    clauses = json.loads(MANIFEST.read_bytes())["clauses"]
    return table(["clause", "what it asks", "silent"], [[f"`{clause['name']}`", clause["meaning"], ", ".join(
        clause.get("silent", []))] for clause in clauses], words=3)


TABLES = {"conformance": conformance, "conformance-clauses": conformance_clauses, "conformance-set": conformance_set}
