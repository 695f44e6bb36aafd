# SPDX-License-Identifier: Apache-2.0
"""What a mutant is, and how the tables write them.

A mutant changes one file in one place or in several. A change is written as git shows a word that differs: the text
`a [-old-]{+new+} b`, without `{+new+}`, stands in the file once; what replaces it is without `[-old-]`.
"""
import re
from dataclasses import dataclass


@dataclass(frozen=True)
class In:
    """Where mutants are, and which tests must notice them.

    `test` is the command of the program that must. Without one, the stability tests must. Then a file of
    `backends/cpu`, `backends/cuda` or `backends/reference` is compiled into that backend or the reference, any other
    into the serial backend or the one that `suite` names. `sources` are the sources of the cpu or cuda backend that are
    compiled with the defect; of a header they must be named.
    """
    file: str
    suite: str = ""
    sources: tuple = ()
    test: str = ""


@dataclass(frozen=True)
class Mutant(In):
    name: str = ""
    changes: tuple = ()  # pairs of an old text and a new one
    equivalent: str = ""  # why nothing can show the mutant: the tests must then pass
    quick: bool = False  # whether it is of the selection that ctest runs

    def backend(self):
        folder = self.file.split("/")[1]
        return self.suite or (folder if self.file.startswith("backends/") else "serial")


def old_and_new(change):
    old, new = r"\[-(.*?)-\]", r"\{\+(.*?)\+\}"
    return tuple(re.sub(kept, r"\1", re.sub(left_out, "", change, flags=re.DOTALL), flags=re.DOTALL)
                 for kept, left_out in ((old, new), (new, old)))


def defects(subject, where, *rows):
    """Mutants of a subject. Each row has what is wrong, its change or several, and possibly other members."""
    where = where if isinstance(where, In) else In(where)
    for wrong, changes, *others in rows:
        changes = (changes,) if isinstance(changes, str) else changes
        yield Mutant(**vars(where), name=f"{subject}: {wrong}", changes=tuple(map(old_and_new, changes)),
                     **(others[0] if others else {}))
