# SPDX-License-Identifier: Apache-2.0
"""Packs rows of the conformance set's judge as they are stored, a line for each renderer:

    python3 benchmarks/conformance/results.py ROWS.json STORED.json

`verdicts` has a letter a clause, in the order of `clauses`: right, differs, explained by what is nearest, not drawn.
`nearest` has places in `names`; a row in which nothing is nearest has none.
"""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SET = ROOT / "tests/conformance/set"


def judged(renderer, folder):
    """Rows of a renderer, as shipped, whose canvases lie in `folder`. Prints the judge's table."""
    print(f"\n{renderer}", flush=True)
    subprocess.run([sys.executable, "-B", ROOT / "tests/conformance/judge.py", SET, folder, "--json",
                    folder / "rows.json"], check=False)
    return [{"renderer": renderer, "settings": "as shipped", **row}
            for row in json.loads((folder / "rows.json").read_bytes())]


def packed(document):
    """The text of a stored file. Rows of `document` have renderer, version and settings beside the judge's members."""
    renderers, names = {}, []

    def place(row):
        name = " + ".join(row.get("nearest", []))
        if name and name not in names:
            names.append(name)
        return names.index(name) if name else None
    for row in document["rows"]:
        renderers.setdefault((row["renderer"], row.get("renderer_version", ""), row["settings"]), []).append(row)
    rows = [{"renderer": " ".join(filter(None, (renderer, version))), "settings": settings,
             "verdicts": "".join("e" if row.get("explained") else row["verdict"][0] for row in rows),
             "db": [round(row["db"], 1) if "db" in row else None for row in rows],
             **({"nearest": [place(row) for row in rows],
                 "nearest_db": [round(row["nearest_db"], 1) if row.get("nearest") else None for row in rows]}
                if any(row.get("nearest") for row in rows) else {}),
             "reasons": {row["clause"]: row["reason"] for row in rows if "reason" in row}}
            for (renderer, version, settings), rows in renderers.items()]
    clauses = dict.fromkeys(row["clause"] for row in document["rows"])
    members = {**document, "clauses": list(clauses), "names": names}
    del members["rows"]
    lines = ",\n".join(f"  {json.dumps(row, separators=(',', ':'))}" for row in rows)
    head = ",\n".join(f" {json.dumps(name)}: {json.dumps(value)}" for name, value in members.items())
    return f'{{\n{head},\n "rows": [\n{lines}\n ]\n}}\n'


if __name__ == "__main__":
    pathlib.Path(sys.argv[2]).write_text(packed(json.loads(pathlib.Path(sys.argv[1]).read_bytes())), encoding="utf-8")
