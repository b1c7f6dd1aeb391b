"""Fails if cargo's messages have more than one build of a package that all programs stand on."""

import json
import sys

ONCE = {"spindle_bearing", "spindle_monitor", "spindle_file", "solvers"}

builds = {}
for line in sys.stdin:
    message = json.loads(line)
    name = message.get("target", {}).get("name")
    if message["reason"] == "compiler-artifact" and name in ONCE:
        # Of a test of the library's own there is a program, and no library.
        libraries = (file for file in message["filenames"] if file.endswith(".rlib"))
        builds.setdefault(name, set()).update(libraries)
print(", ".join(f"{name} {len(files)}" for name, files in sorted(builds.items())), "builds, 1 each at most")
if builds.keys() != ONCE or any(len(files) > 1 for files in builds.values()):
    sys.exit("\n".join(file for files in builds.values() for file in sorted(files)))
