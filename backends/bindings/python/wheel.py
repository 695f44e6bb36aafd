#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes a wheel that needs no package of the system but the C and C++ run-time libraries.

    pip wheel ./backends/bindings/python --no-deps -w FOLDER    builds the library by the preset `distribution`, or
    wheel.py BUILD FOLDER                              takes a build by that preset with static libraries

What the library loads is put into the wheel under names of its own, so that it meets no other copy in the process, as
auditwheel does. The tag says which glibc is needed. Needs patchelf and readelf. The same build gives the same bytes.
"""
import base64
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "cmake"))
sys.dont_write_bytecode = True

import licences  # noqa: E402

# What every Linux with the glibc of the tag has. The driver is no such library: it is looked for when it is needed.
SYSTEM = re.compile(r"(lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+)\.so\.\d+|ld-linux-[-\w]+\.so\.\d+)")
METADATA = """Metadata-Version: 2.1
Name: swiftgs
Version: {version}
Summary: Forward rendering of 3D Gaussian splatting
License: Apache-2.0
Requires-Python: >=3.9
Requires-Dist: numpy (>=1.24)
"""
WHEEL = """Wheel-Version: 1.0
Generator: swiftgs
Root-Is-Purelib: false
Tag: {tag}
"""


def needed(path):
    return re.findall(r"\(NEEDED\).*\[(.*)\]", licences.output("readelf", "-d", path))


def glibc_of(paths):
    found = {tuple(map(int, number.split("."))) for path in paths
             for number in re.findall(r"Name: GLIBC_(\d+\.\d+)", licences.output("readelf", "-V", path))}
    return max(found)


def patch(path, *what):
    """One change at a time: patchelf loses some of several."""
    subprocess.run(["patchelf", *what, path], check=True)


def bundle(package, folder):
    """Copies what the package's library loads to `folder`; returns the packages of the system that they come from."""
    library = next(package.glob("libswiftgs_c.so.*"))
    names, sources = {}, set()
    for name, place in re.findall(r"^\t(\S+) => (.*?)(?: \(0x\w+\))?$", licences.output("ldd", library), re.M):
        if SYSTEM.fullmatch(name):
            continue
        if not place.startswith("/"):
            sys.exit(f"wheel: {library.name} needs {name}, expected it among the libraries of the system")
        source = pathlib.Path(place).resolve()
        stem, rest = name.split(".so", 1)
        names[name] = f"{stem}-{hashlib.sha256(source.read_bytes()).hexdigest()[:8]}.so{rest}"
        shutil.copyfile(source, folder / names[name])
        sources.add(licences.package_of(source))
    for path in [library, *sorted(folder.iterdir())]:
        for name in needed(path):
            if name in names:
                patch(path, "--replace-needed", name, names[name])
        if path != library:
            patch(path, "--set-soname", path.name)
        patch(path, "--set-rpath", "$ORIGIN/../swiftgs.libs" if path == library else "$ORIGIN")
    return sources


def check(folder):
    """Every library that is loaded is in the wheel or of the system."""
    libraries = {path.name: path for path in folder.rglob("*.so*")}
    for path in libraries.values():
        for name in needed(path):
            if not SYSTEM.fullmatch(name) and name not in libraries:
                sys.exit(f"wheel: {path.name} needs {name}, expected it in the wheel or in every Linux")
    return libraries.values()


def write(folder, wheel):
    record, info = [], next(folder.glob("*.dist-info"))
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in [*sorted(path for path in folder.rglob("*") if path.is_file()), info / "RECORD"]:
            name = path.relative_to(folder).as_posix()
            if path == info / "RECORD":
                content = "\n".join([*record, f"{name},,", ""]).encode()
            else:
                content = path.read_bytes()
                digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
                record.append(f"{name},sha256={digest},{len(content)}")
            entry = zipfile.ZipInfo(name)  # of 1980: a file's time is no part of the wheel
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, content, zipfile.ZIP_DEFLATED)


def main(build, out):
    build, out = pathlib.Path(build).resolve(), pathlib.Path(out)
    version = re.search(r"^CMAKE_PROJECT_VERSION:STATIC=(.*)$", (build / "CMakeCache.txt").read_text(), re.M)[1]
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        subprocess.run(["cmake", "--install", build, "--component", "python", "--strip", "--prefix", place / "prefix"],
                       check=True, stdout=subprocess.DEVNULL)
        folder = place / "wheel"
        libs, info = folder / "swiftgs.libs", folder / f"swiftgs-{version}.dist-info"
        libs.mkdir(parents=True)
        info.mkdir()
        package = next((place / "prefix").rglob("swiftgs"))
        shutil.move(package, folder / "swiftgs")
        sources = bundle(folder / "swiftgs", libs)
        major, minor = glibc_of(check(folder))
        tag = f"py3-none-manylinux_{major}_{minor}_{licences.output('uname', '-m').strip()}"
        (info / "METADATA").write_text(METADATA.format(version=version))
        (info / "WHEEL").write_text(WHEEL.format(tag=tag))
        (info / "third-party-licences.txt").write_text(licences.report(build, sources))
        (info / "licenses").mkdir()
        for source in sources:
            shutil.copyfile(f"/usr/share/doc/{source}/copyright", info / "licenses" / source)
        out.mkdir(parents=True, exist_ok=True)
        wheel = out / f"swiftgs-{version}-{tag}.whl"
        write(folder, wheel)
    return wheel


def build_library(cuda):
    """A build of the library, in the folder that an earlier one left."""
    missing = [name for name in ("cmake", "ninja", "patchelf", "readelf", "dpkg") if not shutil.which(name)]
    if missing:
        sys.exit(f"wheel: found no {', '.join(missing)}, expected what cmake/packages.txt lists; cmake/setup.sh test "
                 "installs it")
    build = ROOT / "build" / "wheel"
    subprocess.run(["cmake", "--preset", "distribution", "-B", build, "-DBUILD_SHARED_LIBS=OFF",
                    "-DSWIFTGS_BUILD_EXAMPLES=OFF", f"-DSWIFTGS_BUILD_CUDA={cuda}"], cwd=ROOT, check=True)
    subprocess.run(["cmake", "--build", build, "--target", "swiftgs_c"], check=True)
    return build


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):  # pylint: disable=unused-argument
    """What pip calls (PEP 517). Settings: `cuda`, ON or OFF, by default whether there is nvcc; `build`, a build that is
    there already."""
    settings = config_settings or {}
    cuda = settings.get("cuda", "ON" if shutil.which("nvcc") else "OFF")
    return main(settings.get("build") or build_library(cuda), wheel_directory).name


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: wheel.py BUILD FOLDER")
    print(main(*sys.argv[1:]))
