#!/usr/bin/env python3
"""Installs a build, moves the installed tree away from where it was installed, and lets another project find it there by
CMake and by pkg-config: it evaluates files of three formats and gets the values of the installed program. The installed
headers are listed, and a shared library shows no symbol beyond them.

usage: check_installed.py BUILD_DIR SOURCE_DIR WORK_DIR VERSION CXX [FLAG...]
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

HEADERS = ["include/sbrdf/sbrdf.h"]
PAIR = "theta_i,phi_i,theta_v,phi_v\n30,0,45,180\n"


def run(*command, env=None, text=None):
    done = subprocess.run([str(word) for word in command], input=text, capture_output=True, text=True, env=env)
    if done.returncode != 0:
        sys.exit(f"failed: {' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def install(build, work):
    run("cmake", "--install", build, "--prefix", work / "first")
    prefix = work / "prefix"
    (work / "first").rename(prefix)
    return prefix


def check_paths(prefix, forbidden):
    for path in [*prefix.rglob("*.cmake"), *prefix.rglob("*.pc")]:
        for folder in forbidden:
            if str(folder) in path.read_text():
                sys.exit(f"{path} names {folder}: the package cannot be moved")


def check_headers(prefix):
    found = sorted(str(path.relative_to(prefix)) for path in (prefix / "include").rglob("*") if path.is_file())
    print("installed headers:", ", ".join(found))
    if found != HEADERS:
        sys.exit(f"expected {HEADERS}")


def check_symbols(library):
    """Those that nm shows beyond the API; weak ones count."""
    names = run("nm", "-D", "--defined-only", "-C", library).splitlines()
    symbols = [re.sub(r"^[0-9a-f]* *\S+ ", "", line) for line in names]
    beyond = [name for name in symbols if not re.match(r"sbrdf::(Material::|pair_from_degrees|version)|SBRDF_\d", name)]
    print(f"{library.name}: {len(symbols)} symbols, {len(beyond)} beyond the API")
    if beyond:
        sys.exit("\n".join(beyond))


def build_by_cmake(source, work, prefix, version, cxx, flags):
    folder = work / "by_cmake"
    run("cmake", "-S", source / "tests/consumer", "-B", folder, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}",
        f"-DCMAKE_CXX_COMPILER={cxx}", f"-DCMAKE_CXX_FLAGS={' '.join(flags)}", "-DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF",
        f"-DSBRDF_VERSION={version}")
    run("cmake", "--build", folder)
    return folder / "consumer"


def build_by_pkg_config(source, work, prefix, cxx, flags):
    folder = next(prefix.rglob("sbrdf.pc")).parent
    env = {**os.environ, "PKG_CONFIG_PATH": str(folder)}
    words = run("pkg-config", "--cflags", "--libs", "sbrdf", env=env).split()
    program = work / "by_pkg_config"
    run(cxx, "-std=c++20", *flags, source / "tests/consumer/main.cpp", "-o", program, *words,
        f"-Wl,-rpath,{folder.parent}")
    return program


def main():
    if len(sys.argv) < 6:
        print(__doc__, file=sys.stderr)
        return 1
    build, source, work = (pathlib.Path(name).resolve() for name in sys.argv[1:4])
    version, cxx, *flags = sys.argv[4:]
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    prefix = install(build, work)
    check_paths(prefix, [source, work])
    check_headers(prefix)
    shared = "BUILD_SHARED_LIBS:BOOL=ON" in (build / "CMakeCache.txt").read_text()
    if shared != bool(list(prefix.rglob("libsbrdf.so"))):
        sys.exit("the library is not of the kind that was asked for")
    for library in prefix.rglob("libsbrdf.so"):
        check_symbols(library.resolve())
    consumers = [build_by_cmake(source, work, prefix, version, cxx, flags),
                 build_by_pkg_config(source, work, prefix, cxx, flags)]
    program = prefix / "bin/sbrdf"
    if not program.exists():
        print("the program is not built: no values to compare")
        return 0
    files = [work / "material.sbrdf", work / "material.binary", source / "tests/vectors/rgl/small.bsdf"]
    run(program, "convert", "kurt:fabric112", files[0], "--samples", "500", "--placement", "28/180")
    run(program, "convert", files[0], files[1])
    expected = [run(program, "eval", path, text=PAIR).splitlines()[1].split(",", 4)[4] for path in files]
    for consumer in consumers:
        values = run(consumer, *files).splitlines()
        if values != expected:
            sys.exit(f"{consumer} gives {values}, the program {expected}")
    print("values by CMake and by pkg-config:", "; ".join(expected))
    return 0


if __name__ == "__main__":
    sys.exit(main())
