#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""q̈ of the planar chain by qdot and by its peers, in one run.

    src/bench/peers/peers.py [--work DIR] [--json FILE] [--flags "-O3 -march=native"] [--offline]

Installs what pip and apt offer into DIR (default build/peers, several hundred MB: CasADi, Pinocchio, heyoka, Ceres' headers), builds one
shared library for each peer and measures them in turn over the same 64 states, beside equations derived by hand. heyoka, which evaluates
many states by one call, runs in a process of its own after them. A peer that cannot be
installed or built is reported as absent, with the reason. With --offline nothing is downloaded.
"""
import argparse
import glob
import json
import os
import shutil
import subprocess
import sys

here = os.path.dirname(os.path.abspath(__file__))
src = os.path.dirname(os.path.dirname(here))
sizes = [1, 2, 4, 8, 16]


class Absent(Exception):
    """Why a peer cannot be measured here, in a few words."""


def ran(command, reason, **how):
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=True, **how)
    except FileNotFoundError:
        raise Absent(f"no program {command[0]}") from None
    except subprocess.TimeoutExpired:
        raise Absent(f"{reason}: too slow") from None
    except subprocess.CalledProcessError as error:
        lines = [line for line in error.stderr.splitlines() if line.strip()]
        errors = [line for line in lines if "error" in line.lower()] or lines[-1:] or ["no message"]
        raise Absent(f"{reason}: {errors[0].strip()[:160]}") from None
    return done.stdout


def built(options, name, sources, *flags):
    library = os.path.join(options.work, f"{name}.so")
    command = [options.compiler, "-std=c++20", *options.flags.split(), "-DNDEBUG", "-w", "-shared", "-fPIC", f"-I{src}",
               f"-I{os.path.dirname(src)}/include", "-isystem", options.eigen, *flags, *sources, "-o", library]
    ran(command, "does not build", timeout=900)
    return library


def source(name):
    return os.path.join(here, name)


def package_python(options, package):
    """The Python of a virtual environment that has the package."""
    if options.offline and not os.path.exists(options.python):
        raise Absent("not installed, and --offline")
    if not os.path.exists(options.python):
        ran([sys.executable, "-m", "venv", os.path.join(options.work, "venv")], "no virtual environment")
    try:
        ran([options.python, "-c", f"import {'pinocchio' if package == 'pin' else package}"], "cannot be imported")
    except Absent:
        if options.offline:
            raise Absent("not installed, and --offline") from None
        ran([options.python, "-m", "pip", "install", "--quiet", "--no-input", "--only-binary", ":all:", package],
            "pip cannot install it", timeout=1800)
    return options.python


def casadi(options):
    code = os.path.join(options.work, "casadi_chain.c")
    ran([package_python(options, "casadi"), source("casadi_chain.py"), code, *map(str, sizes)], "generates no code", timeout=600)
    ran(["cc", *options.flags.split(), "-fPIC", "-c", code, "-o", code + ".o"], "does not build", timeout=900)
    return built(options, "casadi", [source("casadi.cxx"), code + ".o"])


def pinocchio(options):
    python = package_python(options, "pin")
    prefixes = glob.glob(os.path.join(os.path.dirname(os.path.dirname(python)), "lib/python3*/site-packages/cmeel.prefix"))
    if not prefixes:
        raise Absent("its wheel brings no headers")
    return built(options, "pinocchio", [source("pinocchio.cxx")], "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
                 "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS", "-isystem", os.path.join(prefixes[0], "include"))


def ceres(options):
    include = options.ceres or os.path.join(options.work, "ceres/usr/include")
    if not os.path.exists(os.path.join(include, "ceres/jet.h")):
        if os.path.exists("/usr/include/ceres/jet.h"):
            include = "/usr/include"
        elif options.offline:
            raise Absent("not installed, and --offline")
        else:
            ran(["apt-get", "download", "libceres-dev"], "apt cannot download libceres-dev", cwd=options.work, timeout=600)
            package = glob.glob(os.path.join(options.work, "libceres-dev_*.deb"))[0]
            ran(["dpkg", "-x", package, os.path.join(options.work, "ceres")], "cannot be unpacked")
    return built(options, "ceres", [source("ceres.cxx")], *([] if include == "/usr/include" else ["-isystem", include]))


def autodiff(options):
    raise Absent("neither pip nor apt has its headers")


def by_driver(options, libraries):
    """{library name: {n: (ns, difference)}}, measured in turn in one process."""
    driver = os.path.join(options.work, "driver")
    ran([options.compiler, "-std=c++20", "-O2", f"-I{src}", source("driver.cxx"), "-o", driver, "-ldl"], "driver does not build")
    found = {}
    for line in ran([driver, *libraries], "driver fails", timeout=600).splitlines():
        library, n, ns, difference = line.split()
        found.setdefault(os.path.basename(library)[:-3], {})[int(n)] = (float(ns), float(difference))
    return found


def heyoka(options):
    text = ran([package_python(options, "heyoka"), source("heyoka_chain.py"), *[str(n) for n in sizes if n <= 8]], "fails", timeout=1800)
    return {int(n): (float(ns), float(difference)) for _, n, ns, difference in map(str.split, text.splitlines())}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", default=os.path.join(os.path.dirname(src), "build/peers"), help="where things are built")
    parser.add_argument("--python", help="Python of an environment with the packages, instead of DIR/venv")
    parser.add_argument("--ceres", help="include directory of Ceres")
    parser.add_argument("--eigen", default="/usr/include/eigen3", help="include directory of Eigen")
    parser.add_argument("--compiler", default="g++")
    parser.add_argument("--flags", default="-O3 -march=native")
    parser.add_argument("--json", help="write the rows here")
    parser.add_argument("--offline", action="store_true", help="use only what is installed")
    options = parser.parse_args()
    options.work = os.path.abspath(options.work)
    os.makedirs(options.work, exist_ok=True)
    options.python = os.path.abspath(options.python) if options.python else os.path.join(options.work, "venv/bin/python")
    if not shutil.which(options.compiler):
        sys.exit(f"peers.py: no compiler {options.compiler}; name another with --compiler")

    def say(text):
        print(text, file=sys.stderr, flush=True)

    libraries, absent, found = [built(options, "hand", [source("hand.cxx")])], {}, {}
    own = [("qdot_unroll", "qdot, qdot::unroll"), ("qdot_for", "qdot, for"), ("qdot_ensemble", "qdot, ensemble of 1024 states")]
    for name, _ in own:
        libraries.append(built(options, name, [source(f"{name}.cxx")]))
    others = [("casadi", "CasADi, generated C", casadi), ("pinocchio", "Pinocchio, ABA", pinocchio),
              ("ceres", "Ceres jets, nested", ceres), ("autodiff", "autodiff, second-order duals", autodiff)]
    for name, title, build in others:
        say(f"{title} …")
        try:
            libraries.append(build(options))
        except Absent as reason:
            absent[title] = str(reason)
    found = by_driver(options, libraries)
    title_of = dict(own) | {name: title for name, title, _ in others}
    batch = "heyoka, 1024 states per call"
    say(f"{batch} …")
    try:
        found["heyoka"] = heyoka(options)
        title_of["heyoka"] = batch
    except Absent as reason:
        absent[batch] = str(reason)

    hand = found.pop("hand")
    rows = [{"system": "chain", "n": n, "peer": title_of[name], "baseline_ns": hand[n][0], "peer_ns": ns, "ratio": round(ns / hand[n][0], 3),
             "difference": difference}
            for name, of_n in found.items() for n, (ns, difference) in of_n.items()]
    print(f"| n | {' | '.join(map(str, sizes))} |")
    print("|---" * (len(sizes) + 1) + "|")
    print(f"| derived by hand, ns | {' | '.join(f'{hand[n][0]:.1f}' for n in sizes)} |")
    for name, of_n in found.items():
        cells = [f"{of_n[n][0] / hand[n][0]:.2f}" if n in of_n else "–" for n in sizes]
        print(f"| {title_of[name]} | {' | '.join(cells)} |")
    for title, reason in absent.items():
        print(f"| {title} | absent: {reason} |" + " |" * (len(sizes) - 1))
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump({"flags": options.flags, "rows": rows, "absent": absent}, file, indent=2, ensure_ascii=False)


if __name__ == "__main__":
    try:
        main()
    except Absent as problem:
        sys.exit(f"peers.py: {problem}")
