# SPDX-License-Identifier: Apache-2.0
"""The pages that are no files: help of every command, docstrings of the Python module."""
import ast
import itertools
import os
import pathlib
import re
import subprocess
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[2]
PART_OF = {"docs/command_line.md": "command_line_options", "docs/python.md": "python_reference"}
PACKAGE = ROOT / "backends/bindings/python/swiftgs"
NO_TOOL = "No tool was built when this page was written. Run `./demo.sh`, which builds one, and `docs/site.sh` again.\n"


def command_line():
    """Help by the tool that SWIFTGS_TOOL names, or else by the newest one of the build folders."""
    built = [path for path in ROOT.glob("build/*/examples/swiftgs") if path.is_file()]
    tool = os.environ.get("SWIFTGS_TOOL") or max(built, key=lambda path: path.stat().st_mtime, default=None)

    def helped(*command):
        text = subprocess.run([tool, *command, "--help"], capture_output=True, text=True, check=True).stdout
        title = " ".join(("swiftgs", *command))
        return f"## {title} {{#{'_'.join(('options', *command))}}}\n\n```{{.unparsed}}\n{text.strip()}\n```\n", text

    lines = ["# Options of every command {#command_line_options}\n"]
    if not tool:
        return "\n".join([*lines, NO_TOOL])
    page, text = helped()
    commands = re.findall(r"^  (\w+)  ", re.search(r"^Subcommands:\n(.*?)\n\n", text, re.M | re.S)[1], re.M)
    return "\n".join([*lines, page, *(helped(command)[0] for command in commands)])


def documented(node):
    """A docstring as Markdown."""
    paragraphs = (ast.get_docstring(node) or "").split("\n\n")
    return "\n\n".join(f"```{{.py}}\n{text}\n```" if text.startswith(">>>") else text for text in paragraphs) + "\n"


def signature(node, source):
    """The lines of a function or class before its docstring."""
    first = min(part.lineno for part in (node, *node.decorator_list))
    text = textwrap.dedent("\n".join(source[first - 1:node.body[0].lineno - 1])).strip()
    return f"```{{.py}}\n{re.sub(r' *# pylint.*', '', text)}\n```\n"


def value(node, source):
    """A field, with the comment beside it or above it."""
    code, _, comment = source[node.lineno - 1].strip().partition("  #: ")
    above = itertools.takewhile(lambda line: line.strip().startswith("#: "), reversed(source[:node.lineno - 1]))
    return f"- `{code}` {' '.join([*(line.strip()[3:] for line in reversed([*above])), comment])}"


def entry(node, source):
    """A function, or a class with its values and its public functions."""
    lines = [f"## {node.name} {{#module_{node.name.lower()}}}\n", signature(node, source), documented(node)]
    functions = []
    for part in node.body if isinstance(node, ast.ClassDef) else ():
        if isinstance(part, ast.AnnAssign):
            lines.append(value(part, source))
        elif isinstance(part, ast.FunctionDef) and (part.name == "__init__" or not part.name.startswith("_")):
            decorators = [ast.unparse(decorator) for decorator in part.decorator_list]
            if "property" in decorators:
                text = " ".join(documented(part).split())
                lines.append(f"- `{part.name}: {ast.unparse(part.returns)}` {text}")
            elif f"{part.name}.setter" not in decorators:
                functions += [signature(part, source), documented(part)]
    return [*lines, "", *functions]


def python():
    package = ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8"))
    lines = ["# Reference of the Python module {#python_reference}\n", documented(package)]
    found = {}
    for file in sorted(PACKAGE.glob("_*.py")):
        text = file.read_text(encoding="utf-8")
        for node in ast.parse(text).body:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                found[node.name] = entry(node, text.splitlines())
            elif isinstance(node, ast.AnnAssign):
                name = node.target.id
                found[name] = [f"## {name} {{#module_{name.lower()}}}\n", value(node, text.splitlines()), ""]
    names = next(ast.literal_eval(node.value) for node in package.body
                 if isinstance(node, ast.Assign) and node.targets[0].id == "__all__")
    return "\n".join([*lines, *(line for name in names for line in found[name])])


def pages():
    return {"command_line_options.md": command_line(), "python_reference.md": python()}
