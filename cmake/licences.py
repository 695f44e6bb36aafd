#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the packages whose code a build has compiled or linked, with their licences: licences.py BUILD.

Headers and embedded files are those that Ninja knows, libraries those that the products name. Packages and licences are
those of Debian's system; what belongs to no package is named by its folder. A package's licences are all that its
copyright file names, also those of parts that are not used.
"""
import pathlib
import re
import subprocess
import sys

# Of packages whose copyright file a program cannot read.
STATED = {"libc6": "LGPL-2.1+", "libgcc": "GPL-3+ with the GCC runtime library exception",
          "libstdc++": "GPL-3+ with the GCC runtime library exception", "libwebp": "BSD-3-clause",
          "libzip": "BSD-3-clause",
          "CUDA Toolkit": "NVIDIA's licence of the toolkit; CCCL in it is Apache-2.0 with LLVM exceptions"}


def output(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def compiled(build):
    deps = [line.strip() for line in output("ninja", "-C", build, "-t", "deps").splitlines() if line.startswith("    ")]
    embedded = [line for line in output("ninja", "-C", build, "-t", "inputs", "all").splitlines()
                if line.startswith("/usr/share/javascript/")]
    return {pathlib.Path(path).resolve() for path in deps + embedded if path.startswith("/")}


def linked(build):
    products = [path for path in [*build.glob("backends/**/libswiftgs*.so.*"), build / "examples/swiftgs"]
                if path.is_file() and not path.is_symlink()]
    if not products:
        sys.exit(f"licences: expected shared libraries in {build}/backends")
    needed = {name for path in products for name in re.findall(r"\(NEEDED\).*\[(.*)\]", output("readelf", "-d", path))}
    places = {name: place for path in products
              for name, place in re.findall(r"^\t(\S+) => (/\S+)", output("ldd", path), re.M)}
    return {pathlib.Path(places[name]).resolve() for name in needed if name in places}


def package_of(path):
    """By the files' lists: one pass over them is quicker than a question for each of thousands of files."""
    if not package_of.owners:
        for listed in pathlib.Path("/var/lib/dpkg/info").glob("*.list"):
            for line in listed.read_text(encoding="utf-8").splitlines():
                package_of.owners.setdefault(line, listed.stem.split(":")[0])
    for name in (str(path), str(path).removeprefix("/usr")):
        if name in package_of.owners:
            return package_of.owners[name]
    return "CUDA Toolkit" if "/cuda" in str(path) else str(path.parent)


package_of.owners = {}


def licences_of(package):
    for name, licence in STATED.items():
        if re.fullmatch(re.escape(name) + r"[-\d.a-z]*", package):
            return licence
    path = pathlib.Path("/usr/share/doc") / package / "copyright"
    text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
    names = sorted({" ".join(name.split()) for name in re.findall(r"^License:[ \t]*(\S.*)$", text, re.M)})
    return "; ".join(names) or f"see {path}"


def report(build, bundled=()):
    """Of BUILD, and of packages whose libraries are bundled with it."""
    build = pathlib.Path(build).resolve()
    own = re.search(r"^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$", (build / "CMakeCache.txt").read_text(), re.M)[1]
    uses = {"compiled in": {package_of(path) for path in compiled(build) if not path.is_relative_to(own)},
            "loaded": {package_of(path) for path in linked(build)} - set(bundled), "bundled": set(bundled)}
    lines = ["Code of others that SwiftGS is compiled from (headers, embedded files) or loads (shared libraries), by",
             "the package that it comes from. Licences are all that the package's copyright file names.", ""]
    for package in sorted(set().union(*uses.values())):
        how = " and ".join(use for use, packages in uses.items() if package in packages)
        lines.append(f"{package} ({how}): {licences_of(package)}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: licences.py BUILD")
    print(report(sys.argv[1]), end="")
