# SPDX-License-Identifier: Apache-2.0
"""Markdown: tables and the words for numbers in them."""
import textwrap


def table(header, rows, words=1):
    """A table; the first `words` columns are aligned to the left, the others, numbers, to the right."""
    lines = ["| " + " | ".join(header) + " |",
             "|" + "".join(" --- |" if n < words else " ---: |" for n in range(len(header)))]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)


def prose(text):
    """A paragraph, in lines as long as those of the pages."""
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False)


def significant(value, digits=3):
    """`value` with that many significant digits, in scientific notation below a thousandth; '-' for None."""
    if value is None or value == 0:
        return "-" if value is None else "0"
    exponent = int(f"{value:.{digits - 1}e}".split("e")[1])
    return f"{value:.{digits - 1}e}" if exponent < -3 else f"{value:,.{max(digits - 1 - exponent, 0)}f}"


def ms(value):
    """Milliseconds."""
    return significant(value)


def times(value, spread=None):
    """A factor, as 1.25x, with ~ before it where it is within the spread of the same work measured again."""
    if value is None:
        return "-"
    return ("~" if spread is not None and 1 / spread <= value <= spread else "") + f"{value:.2f}x"


def timed(milliseconds, factor, spread=None):
    """Milliseconds and a factor; '-' where they were not measured."""
    return "-" if milliseconds is None else f"{ms(milliseconds)} ({times(factor, spread)})"


def heading(text, spread):
    """What stands before a table, and where a spread is known what ~ means."""
    return prose(f"{text}:" if spread is None else f"{text}. Where a factor has a ~, no difference was measured: the same "
                 f"work measured again differs by up to {100 * (spread - 1):.1f} %.")


def quotient(value, base):
    """A number over another, as 1.06."""
    return "-" if None in (value, base) else f"{value / base:.2f}"


def count(value):
    """A number of things."""
    return "-" if value is None else f"{value:,.0f}"


def decibel(value):
    """A PSNR; that of equal images is infinite."""
    return "-" if value is None else "equal" if value == float("inf") else f"{value:.1f}"
