# SPDX-License-Identifier: Apache-2.0
"""What a mutant is.

A mutant replaces an exact text, which its file has once, in one file. `also` are further texts of the file, each with
what replaces it. `equivalent` says why nothing can show the mutant: the tests must then pass. `quick` marks the
selection that ctest runs.

`test` is the command of the program that must notice it. Without one, the stability tests must. Then a file of
`backends/cpu` or `backends/cuda` is compiled into that backend, any other into the serial one or, where `suite` says
so, into the backend or the reference that it names. `sources` are the sources of the cpu or cuda backend that are
compiled with the defect; of a header they must be named.
"""
from dataclasses import dataclass


@dataclass(frozen=True)
class Mutant:
    name: str
    file: str
    old: str
    new: str
    suite: str = ""
    sources: tuple = ()
    also: tuple = ()
    equivalent: str = ""
    quick: bool = False
    test: str = ""

    def backend(self):
        folder = self.file.split("/")[1]
        return self.suite or (folder if self.file.startswith("backends/") else "serial")
