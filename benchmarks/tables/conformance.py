# SPDX-License-Identifier: Apache-2.0
"""What the judge of the conformance set says of renderers: each in a row, and each clause beside the viewers."""
from collections import Counter
from statistics import median

from tables.markdown import decibel, table

FILES = ("swiftgs.json", "viewers.json")


def judged(source, folder, names=FILES):
    """{(renderer, settings): its rows}, and where they were drawn."""
    found, machines = {}, {}
    for name in names:
        if source.has(folder, name):
            about, rows = source.rows(folder, name, "swiftgs-conformance")
            for row in rows:
                key = f"{row.renderer} {row.renderer_version}".strip(), row.settings
                found.setdefault(key, []).append(row)
                machines[key] = about
    return found, machines


def conformance(source, folder):
    """How many clauses of the set each renderer draws right, and what the others have in common."""
    found, machines = judged(source, folder)
    lines = []
    for (renderer, settings), rows in found.items():
        verdicts = Counter(row.verdict for row in rows)
        named = Counter(name for row in rows for name in row.nearest or [])
        lines.append([renderer, settings, ", ".join(f"{name} ({count})" for name, count in named.most_common(3)) or "-",
                      str(verdicts["right"]), str(verdicts["differs"]), str(sum(bool(row.explained) for row in rows)),
                      str(verdicts["not drawn"]), decibel(median(row.db for row in rows if row.db is not None))])
    where = dict.fromkeys(f"{about['gpu']}, {about['date']}" for about in machines.values() if about.get("gpu"))
    return (f"Browsers' viewers on {'; '.join(where)}:\n\n" + table(
        ["renderer", "settings", "named most, in how many clauses", "right", "differ", "explained", "not drawn",
         "median dB"], lines, words=3))


def conformance_clauses(source, folder):
    """Each clause in each viewer at its best settings."""
    found, _ = judged(source, folder, FILES[1:])
    best = {renderer: {row.clause: row for row in found[renderer, settings]} for renderer, settings in sorted(
        found, key=lambda key: key[1] == "best")}

    def cell(row):
        if row.verdict != "differs":
            return row.verdict
        names = " + ".join(row.nearest)
        nearest = decibel(row.nearest_db) + (", every pixel" if row.explained else "")
        return decibel(row.db) + (f": {names} ({nearest})" if names else "")
    clauses = dict.fromkeys(clause for rows in best.values() for clause in rows)
    return table(["clause", *best], [[clause, *(cell(rows[clause]) for rows in best.values())] for clause in clauses],
                 words=1 + len(best))


TABLES = {"conformance": conformance, "conformance-clauses": conformance_clauses}
