# SPDX-License-Identifier: Apache-2.0
"""What planes beside colour cost."""
from tables.markdown import ms, table
from tables.results import InputError, check_rows
from tables.source import backend, device

NAME = "planes.json"


def planes(source, machine):
    """Frames with each set of planes over those of colour alone."""
    path = source.path(machine, NAME)
    results = source.json(machine, NAME, "swiftgs-planes", rows=list)
    check_rows(path, results["rows"], texts=("scene", "renderer", "planes"), counts=("ms",))
    scenes = list(dict.fromkeys(row["scene"] for row in results["rows"]))
    sets = list(dict.fromkeys(row["planes"] for row in results["rows"]))
    found = {(row["scene"], row["planes"]): row["ms"] for row in results["rows"]}
    for scene in scenes:
        if any((scene, words) not in found for words in ["", *sets]):
            raise InputError(f"{path}: scene {scene!r}: expected the same sets of planes as of others, with none first")
    rows = [["colour alone, ms"] + [ms(found[scene, ""]) for scene in scenes]]
    for words in sets:
        if words:
            names = ", ".join(f"`{name}`" for name in words.split(","))
            rows.append([names] + [f"{found[scene, words] / found[scene, '']:.2f}" for scene in scenes])
    return (f"{device(results['machine'], backend(machine))}, `{results['rows'][0]['renderer']}`, first views; frames "
            "over those of colour alone:\n\n" + table(["planes beside colour", *scenes], rows))


TABLES = {"planes": planes}
