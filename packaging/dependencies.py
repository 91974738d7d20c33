"""The libraries that the released programs hold, of `cargo metadata`: those of Linux and Windows, not of tests or builds."""

import json
import subprocess
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SYSTEMS = ["x86_64-unknown-linux-gnu", "x86_64-pc-windows-gnu"]


def of_system(system, features):
    """The program's package, the others by id, and what each needs."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", system, "--features", features]
    found = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)
    packages = {package["id"]: package for package in found["packages"]}
    needs = {
        node["id"]: [dep["pkg"] for dep in node["deps"] if any(kind["kind"] is None for kind in dep["dep_kinds"])]
        for node in found["resolve"]["nodes"]
    }
    return found["resolve"]["root"], packages, needs


def released(features="excel,page"):
    """The program's package, and its libraries in the order of their names, each with the ids that it needs."""
    packages, needs, root = {}, {}, None
    for system in SYSTEMS:
        root, all_packages, all_needs = of_system(system, features)
        waiting = [root]
        while waiting:
            own = waiting.pop()
            seen = needs.setdefault(own, set())
            packages[own] = all_packages[own]
            new = set(all_needs[own]) - seen
            seen |= new
            waiting += new
    libraries = sorted((p for i, p in packages.items() if i != root), key=lambda p: (p["name"], p["version"]))
    return packages[root], libraries, needs


def checksums():
    """SHA-256 of each library as it was fetched, by name and version."""
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())
    return {(p["name"], p["version"]): p["checksum"] for p in lock["package"] if "checksum" in p}
