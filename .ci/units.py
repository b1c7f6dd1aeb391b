"""Fails if cargo's messages have more builds of the library than so many."""

import json
import sys

units = set()
for line in sys.stdin:
    message = json.loads(line)
    is_library = message.get("target", {}).get("name") == "spindle_bearing"
    if message["reason"] == "compiler-artifact" and is_library:
        # Of a test of the library's own there is a program, and no library.
        units.update(name for name in message["filenames"] if name.endswith(".rlib"))
most = int(sys.argv[1])
print(f"{len(units)} builds of the library, {most} at most")
if len(units) > most:
    sys.exit("\n".join(sorted(units)))
