"""Runs the commands that README and docs show: those of every block of `sh`.

Blocks of `console` are for boards and are not run: their lines begin with `$`. A command that the script of the
continuous integration has itself, given as argument, is not run a second time.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "examples").glob("**/README.md")), *sorted((ROOT / "host_tests").glob("**/README.md"))]
# The package is added to a program of its own in the step "package".
ELSEWHERE = {"cargo add spindle-bearing", "cargo test"}


def commands(page):
    """The commands of a page, with the number of their lines."""
    block = None
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if line.startswith("```"):
            block = None if block is not None else line[3:].strip()
            joined = ""
        elif block == "sh":
            joined += re.sub(r"(^|\s)#.*", "", line).rstrip()
            if joined.endswith("\\"):
                joined = joined[:-1]
            elif joined.strip():
                yield number, " ".join(joined.split())
                joined = ""
            else:
                joined = ""
        elif block == "console" and line and line[0] not in "$ ":
            sys.exit(f"{page}:{number}: a line of a console begins with `$`, or with blanks if it goes on")


def main():
    own = pathlib.Path(sys.argv[1]).read_text().replace("\\\n", " ").splitlines()
    seen = ELSEWHERE | {" ".join(line.split()) for line in own}
    for page in PAGES:
        for number, command in commands(page):
            if command in seen:
                continue
            seen.add(command)
            print(f"-- {page.relative_to(ROOT)}:{number}: {command}", flush=True)
            done = subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=ROOT, stdout=subprocess.DEVNULL)
            if done.returncode:
                sys.exit(f"{page.relative_to(ROOT)}:{number}: ends with {done.returncode}: {command}")


main()
