# SPDX-License-Identifier: Apache-2.0
"""Compares the binary interface of libswiftgs_c with the one that is recorded.

The interface is what the headers in include/swiftgs/c declare, with the layout that a compiler gives it: functions,
callbacks, enumerators, and every member of every struct. The library must export these functions and nothing else, and
no struct may have padding, which later members could not be told from. With --update the record is written anew, unless
the numbers of the interface should have been raised before.
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

ADVICE = "then record it: cmake --build BUILD --target swiftgs_record_abi"


def without_comments(text):
    """C code alone: no comments, no preprocessor."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    text = re.sub(r"//[^\n]*", "", text)
    return re.sub(r"^\s*#[^\n]*(?:\\\n[^\n]*)*", "", text, flags=re.MULTILINE)


def one_line(text):
    return re.sub(r"\s+", " ", text).strip()


def members_of(body):
    """(type, name) of each member. Those of one declaration share the type."""
    for declaration in filter(None, map(one_line, body.split(";"))):
        first, *others = declaration.split(",")
        kind, name = re.fullmatch(r"(.*[ *])(\w+(?:\[\w+\])?)", first.strip()).groups()
        for each in [name, *map(str.strip, others)]:
            plain, count = re.fullmatch(r"(\w+)(\[\w+\])?", each).groups()
            yield kind.strip() + (count or ""), plain


def declared(text):
    """What a header declares, its comments removed."""
    structs = {name: list(members_of(body))
               for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\} \1;", text, flags=re.DOTALL)}
    enumerators = re.findall(r"\b(SWIFTGS_\w+) =", " ".join(re.findall(r"enum \{(.*?)\};", text, flags=re.DOTALL)))
    functions = [without_parameter_names(one_line(f)) for f in re.findall(r"SWIFTGS_C_API ([^;]*);", text)]
    callbacks = [without_parameter_names(one_line(f))
                 for f in re.findall(r"typedef ([^;{]*\(\*\w+\)[^;]*);", text)]
    return structs, enumerators, functions, callbacks


def without_parameter_names(function):
    """Types alone, because programs are compiled against no more."""
    head, parameters = function.rsplit("(", 1)
    parameters = re.sub(r"([ *])\w+(?=[,)])", r"\1", parameters)
    return f"{head}({parameters}".replace(" ,", ",").replace(" )", ")")


def name_of(function):
    return re.search(r"(\w+)\(", function).group(1)


def layout_program(structs, enumerators):
    lines = ["#include <stddef.h>", "#include <stdio.h>", "#include <swiftgs.h>", "int main(void) {",
             '  printf("abi %d.%d\\n", SWIFTGS_ABI_MAJOR, SWIFTGS_ABI_MINOR);']
    lines += [f'  printf("value {name} = %d\\n", (int){name});' for name in enumerators]
    for struct, members in structs.items():
        lines.append(f'  printf("struct {struct}: %zu bytes\\n", sizeof({struct}));')
        for kind, member in members:
            lines.append(f'  printf("member {struct}.{member}: {kind}, byte %zu, %zu bytes\\n", '
                         f"offsetof({struct}, {member}), sizeof((({struct}*)0)->{member}));")
    return "\n".join([*lines, "  return 0;", "}", ""])


def interface(include, compiler):
    """The lines of a record, and the functions that a library must export."""
    text = "".join(without_comments(path.read_text()) for path in sorted((include / "swiftgs/c").glob("*.h")))
    structs, enumerators, functions, callbacks = declared(text)
    with tempfile.TemporaryDirectory() as folder:
        source, program = pathlib.Path(folder) / "layout.c", pathlib.Path(folder) / "layout"
        source.write_text(layout_program(structs, enumerators))
        subprocess.run([compiler, "-std=c11", f"-I{include}", str(source), "-o", str(program)], check=True)
        laid_out = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout.splitlines()
    lines = [laid_out[0], *sorted(f"function {f}" for f in functions), *sorted(f"callback {c}" for c in callbacks)]
    return lines + laid_out[1:], {name_of(f) for f in functions}


def padding(lines):
    """A sentence for each place where a struct has bytes between its members or behind them."""
    found, at, struct, size = [], 0, None, 0
    for line in [*lines, "struct end: 0 bytes"]:
        if match := re.fullmatch(r"struct (\w+): (\d+) bytes", line):
            if struct and at != size:
                found.append(f"struct {struct}: padding at byte {at}, expected members without gaps")
            struct, size, at = match.group(1), int(match.group(2)), 0
        elif match := re.fullmatch(r"member ([\w.]+): .*, byte (\d+), (\d+) bytes", line):
            if int(match.group(2)) != at:
                found.append(f"member {match.group(1)}: padding before it, expected members without gaps")
            at = int(match.group(2)) + int(match.group(3))
    return found


def sizes(lines):
    structs = filter(None, (re.fullmatch(r"struct (\w+): (\d+) bytes", line) for line in lines))
    return dict(match.groups() for match in structs)


def version(lines):
    return tuple(map(int, lines[0].removeprefix("abi ").split(".")))


def place_of(line):
    """Of a member: the struct and the bytes that it has there."""
    match = re.fullmatch(r"member (\w+)\.\w+: .*, byte (\d+), (\d+) bytes", line)
    return match and match.groups()


def compare(recorded, found):
    """(sentences that say what differs, whether the numbers of the interface fit that). A reserved member, which all
    programs leave at 0, may be given a name where it is."""
    before, after = sizes(recorded), sizes(found)
    grown = {f"struct {name}: {size} bytes" for name, size in before.items() if int(after.get(name, 0)) > int(size)}
    places = {place for place in map(place_of, found) if place}
    named = {line for line in recorded if re.match(r"member \w+\.reserved:", line) and place_of(line) in places}
    broken = [line for line in recorded[1:] if line not in found and line not in grown and line not in named]
    added = [line for line in found[1:] if line not in recorded]
    old, new = version(recorded), version(found)
    differs = [f"- {line}" for line in recorded if line not in found]
    differs += [f"+ {line}" for line in found if line not in recorded]
    if broken and new[0] == old[0]:
        return differs + ["What is gone or moved breaks programs: restore it, or raise SWIFTGS_ABI_MAJOR and set "
                          f"SWIFTGS_ABI_MINOR to 0 in include/swiftgs/c/status.h, {ADVICE}"], False
    if (added or broken) and new <= old:
        return differs + [f"An addition: raise SWIFTGS_ABI_MINOR in include/swiftgs/c/status.h, {ADVICE}. A struct "
                          "that grew needs its first size in backends/bindings/c/structs.hpp"], False
    return differs + ([f"The numbers fit; {ADVICE.removeprefix('then ')}"] if differs else []), True


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--include", "--library", "--record"):
        parser.add_argument(option, type=pathlib.Path, required=True)
    parser.add_argument("--compiler", required=True)
    parser.add_argument("--nm", required=True)
    parser.add_argument("--update", action="store_true")
    options = parser.parse_args()

    lines, functions = interface(options.include, options.compiler)
    problems = padding(lines)
    symbols = subprocess.run([options.nm, "-D", "--defined-only", str(options.library)], check=True,
                             capture_output=True, text=True).stdout
    exported = {line.split()[-1] for line in symbols.splitlines()}
    problems += [f"{name}: declared, but {options.library} does not export it" for name in sorted(functions - exported)]
    problems += [f"{name}: exported by {options.library}, but not declared" for name in sorted(exported - functions)]

    recorded = options.record.read_text().splitlines() if options.record.exists() else ["abi 0.0"]
    differs, fits = compare(recorded, lines)
    if not options.update or not fits:
        problems += differs
    if problems:
        print("\n".join(problems))
        return 1
    if options.update:
        options.record.write_text("\n".join(lines) + "\n")
    print(f"{lines[0]}: {len(functions)} functions, {len(sizes(lines))} structs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
