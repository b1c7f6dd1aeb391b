"""Fails if the library's `rust-version` is older than what a dependency of any of its features wants, or if the
crates of this repository do not agree on it. Reads the output of `cargo metadata --all-features`."""

import json
import sys


def number(version):
    return [int(part) for part in (version + ".0.0").split(".")[:3]]


def main():
    data = json.load(sys.stdin)
    packages = {package["id"]: package for package in data["packages"]}
    nodes = {node["id"]: node for node in data["resolve"]["nodes"]}
    members = [packages[member] for member in data["workspace_members"]]
    library = next(member for member in members if member["name"] == "spindle-bearing")
    ours = library["rust_version"]
    wrong = [f"{m['name']} says {m['rust_version']}" for m in members if m["rust_version"] != ours]

    reached, waiting = set(), [library["id"]]
    while waiting:
        this = waiting.pop()
        if this in reached:
            continue
        reached.add(this)
        for dependency in nodes[this]["deps"]:
            if any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                waiting.append(dependency["pkg"])
    if len(reached) < 10:
        wrong.append(f"only {len(reached)} packages were looked at: is this with all features?")
    for this in sorted(reached):
        wanted = packages[this]["rust_version"]
        if wanted and number(wanted) > number(ours):
            wrong.append(f"{packages[this]['name']} {packages[this]['version']} wants {wanted}")
    if wrong:
        sys.exit(f"rust-version is {ours}, but " + "; ".join(wrong))
    print(f"rust-version {ours} is enough for {len(reached)} packages")


main()
