# SPDX-License-Identifier: Apache-2.0
"""Tables of Markdown on the standard output."""


def table(header, rows):
    print("| " + " | ".join(header) + " |")
    print("|" + " --- |" * len(header))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print()
