#!/usr/bin/env python3
"""Functions and files of the library on the way of a warm solve.

Counts what a second warm solve runs besides the first one, by the compiler's coverage counters, so that functions in line
count, too. Left out: closures, numbers (real.rs, sqrt.rs), and vectors and matrices of two.

    rustup component add llvm-tools
    python3 host_tests/judge/warm_path.py            counts
    python3 host_tests/judge/warm_path.py --list     and the functions
"""

import collections
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PRIMITIVE_FILES = {"real.rs", "sqrt.rs"}
PRIMITIVES = "dot dots add sub scale times times_transposed product2 turn".split()

PROGRAM = """
use spindle_bearing::*;
const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
const SOLID: Section = Section { from: -0.03, to: 0.1, outer: 0.025, inner: 0.0 };
static SHAFT: Shaft<f32, 1> = Shaft::<f32, 1>::const_new(&[SOLID], &Material::STEEL);
fn main() {
    let mut arguments = std::env::args().skip(1);
    let (scene, ticks) = (arguments.next().unwrap(), arguments.next().unwrap().parse().unwrap());
    let speed = Speed::rpm(20_000.0);
    let pair = Spindle::pair(Arrangement::BackToBack, &BEARING, 0.1, Preload::Force(200.0)).unwrap();
    let housing = Support { axial: 5e8, radial: 5e8, tilting: 1e6 };
    let elastic = pair.elastic(&SHAFT, [housing; 2]).unwrap();
    let (mut one, mut two, mut bent) = (Solver::new(), SpindleSolver::new(), SpindleSolver::new());
    for tick in 0..ticks {
        let load = [500.0, 100.0 + 4.0 * tick as f32, 0.0, 0.0, 1.0];
        let settings = if tick == 0 { Settings::default() } else { Settings::TICK };
        let k = match &*scene {
            "elastic" => bent.solve(&elastic, load, speed, &settings).unwrap().stiffness(),
            "pair" => two.solve(&pair, load, speed, &settings).unwrap().stiffness(),
            _ => one.solve(&BEARING, load, speed, &settings).unwrap().stiffness(),
        };
        assert!(k[0][0] > 0.0);
    }
}
"""


def run(*command, **options):
    return subprocess.run(command, check=True, capture_output=True, text=True, **options).stdout


def counts(folder, binary, tools, *arguments):
    """How often each function of `src` ran, by file and line."""
    raw, data = folder / "raw", folder / "data"
    run(binary, *arguments, env={**os.environ, "LLVM_PROFILE_FILE": str(raw)})
    run(tools / "llvm-profdata", "merge", "-sparse", raw, "-o", data)
    found = json.loads(run(tools / "llvm-cov", "export", binary, f"-instr-profile={data}"))
    times = collections.Counter()
    for function in found["data"][0]["functions"]:
        file = pathlib.Path(function["filenames"][0])
        if file.is_relative_to(ROOT / "src"):
            times[file, function["regions"][0][0]] += function["count"]
    return times


def name(file, line):
    """Name of the function that begins at a line; none of a closure."""
    text = file.read_text().splitlines()[line - 1]
    found = re.search(r"\bfn (\w+)", text)
    return found and found[1]


def main():
    host = re.search("host: (.*)", run("rustc", "-vV"))[1]
    tools = pathlib.Path(run("rustc", "--print", "sysroot").strip(), "lib/rustlib", host, "bin")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "src").mkdir()
        (folder / "src/main.rs").write_text(PROGRAM)
        (folder / "Cargo.toml").write_text(
            '[package]\nname = "warm"\nversion = "0.0.0"\nedition = "2024"\n[workspace]\n'
            f'[dependencies]\nspindle-bearing = {{ path = "{ROOT}" }}\n'
        )
        flags = {**os.environ, "RUSTFLAGS": "-C instrument-coverage", "CARGO_TARGET_DIR": str(folder / "target")}
        run("cargo", "build", "--quiet", cwd=folder, env=flags)
        ways = {}
        for scene in ["bearing", "pair", "elastic"]:
            few, more = (counts(folder, folder / "target/debug/warm", tools, scene, n) for n in ("2", "3"))
            way = {(f, line) for (f, line), n in more.items() if n > few[f, line] and f.name not in PRIMITIVE_FILES}
            named = {(str(f.relative_to(ROOT)), line, name(f, line)) for f, line in way}
            ways[scene] = {of for of in named if of[-1] and of[-1] not in PRIMITIVES}
    bearing, pair, elastic = ways["bearing"], ways["pair"], ways["elastic"]
    of = lambda way: {file for file, *_ in way}
    for title, way, files in [
        ("a bearing", bearing, of(bearing)),
        ("a pair, beyond a bearing", pair - bearing, of(pair) - of(bearing)),
        ("an elastic pair", elastic, of(elastic)),
    ]:
        print(f"{title}: {len(way)} functions, {len(files)} files")
        if "--list" in sys.argv:
            for file in sorted({f for f, *_ in way}):
                print(f"  {file}: {', '.join(sorted(n for f, _, n in way if f == file))}")
    verbs = collections.Counter(n for *_, n in bearing | pair | elastic)
    print(f"most definitions of a verb: {', '.join(f'{n} {v}' for v, n in verbs.most_common(5))}")


main()
