# SPDX-License-Identifier: Apache-2.0
"""Machine code of kernels as cuobjdump and ncu print it."""
import collections
import csv
import re

Instruction = collections.namedtuple("Instruction", "at text guard opcode dests sources target executed lanes")
WIDTH = {"64": 2, "128": 4, "WIDE": 2}
NO_RESULT = ("ST", "BRA", "BAR", "BSYNC", "BSSY", "EXIT", "NOP", "WARPSYNC", "RED", "RET", "CALL", "B2R")


def registers(operand, width=1):
    """Registers and predicates of an operand, of `width` registers where it is one register."""
    found = []
    for name in re.findall(r"\bU?[RP]\d+\b", operand):
        kind, number = re.match(r"(U?[RP])(\d+)", name).groups()
        found += [f"{kind}{int(number) + i}" for i in range(width if kind in ("R", "UR") else 1)]
    return found


def parse(at, text, base=0, executed=0, lanes=0):
    """One instruction; `lanes` are those that its predicate let execute it, over all executions."""
    text = re.sub(r"\s+", " ", text.strip().rstrip(";").strip())
    guard, rest = re.match(r"(?:@!?(U?P\w+) )?(.*)", text).groups()
    opcode, _, operands = rest.partition(" ")
    operands = [o.strip() for o in operands.split(",")] if operands else []
    parts = opcode.split(".")
    target = re.search(r"0x[0-9a-f]+", rest) if parts[0] == "BRA" else None
    if parts[0].startswith(NO_RESULT):
        dests, sources = [], [r for o in operands for r in registers(o)]
    else:
        count = 2 if parts[0].endswith("SETP") else 1
        width = 1 if parts[0] == "MUFU" else max([WIDTH.get(p, 1) for p in parts[1:]] + [2 if opcode == "CS2R" else 1])
        dests = [r for o in operands[:count] for r in registers(o, width)]
        sources = [r for o in operands[count:] for r in registers(o)]
    return Instruction(at - base, text, guard, opcode, dests, sources,
                       target and int(target[0], 16) - base, executed, lanes)


def read_sass(lines):
    """{name: instructions} of cuobjdump's output."""
    kernels, name = {}, None
    for line in lines:
        if match := re.match(r"\s*Function\s*:?\s*(\S+)", line):
            name = match[1]
            kernels[name] = []
        elif name and (match := re.match(r"\s*(?:/\*)?([0-9a-f]{4,})(?:\*/)?\s+(.*?)(?:;|$)", line)):
            kernels[name].append(parse(int(match[1], 16), match[2]))
    return kernels


def read_profile(lines):
    """The same of ncu's output; of several launches of a kernel, the last."""
    kernels, name, columns = {}, None, []
    for row in csv.reader(lines):
        if row and row[0] == "Kernel Name":
            name, base = row[1], None
            kernels[name] = []
        elif row and row[0] == "Address":
            columns = row
        elif name and row and row[0].startswith("0x"):
            fields = dict(zip(columns, row))
            at = int(row[0], 16)
            base = at if base is None else base
            instruction = parse(at, fields["Source"], base, int(fields["Instructions Executed"]),
                                int(fields["Predicated-On Thread Instructions Executed"]))
            kernels[name].append(instruction)
    return kernels


def loops(code):
    """(first, last) index of every loop, the innermost ones first."""
    index = {i.at: n for n, i in enumerate(code)}
    found = [(index[i.target], n) for n, i in enumerate(code) if i.target in index and index[i.target] < n]
    return sorted(found, key=lambda loop: loop[1] - loop[0])
