#!/usr/bin/env python3
"""Instructions of the kernel per path and of traversal per ray, counted exactly, against a recorded baseline.

    apt-get install valgrind binutils
    python3 tools/callgrind.py                    # table, with the change against benches/results/callgrind.json
    python3 tools/callgrind.py --record           # makes that baseline
    python3 tools/callgrind.py --octolux BINARY   # of a build made with RUSTFLAGS as below

Small fixed renders of shipped scenes, one thread, 8 lanes, of a build for x86-64-v3 in target/callgrind (valgrind knows no
AVX-512). Two sample counts are run and the difference is taken: what does not grow with samples falls out. Counts are those
under the kernel's entry points (src/kernel/mod.rs, `run`) and, for rays, under the calls into the accelerator (World::closest,
occluded and their `_many`); instructions are not time, but they see a change of .1 % on a noisy machine.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BASELINE = ROOT / "benches/results/callgrind.json"
FLAGS = "-C target-cpu=x86-64-v3 -C no-vectorize-slp"
# Name, scene, side of the picture, the two sample counts. So small that even under valgrind no pass lasts a second: then the
# sizes of passes, and with them how full waves are, do not depend on the clock (src/render/budget.rs).
SCENES = [
    ("cornell: brute force, diffuse", "cornell/scene.toml", 16, 4, 12),
    ("veach: metals, spheres", "veach/scene.toml", 16, 4, 12),
    ("sun-sky: glass, gold, image, tree", "sun-sky/scene.toml", 16, 4, 12),
    ("courtyard: textures, cut-outs, tree", "courtyard/scene.toml", 16, 4, 12),
    ("stage: Phong, lights without extent", "stage/scene.toml", 16, 4, 12),
    ("course: gather by 40 directions", "course/scene.toml", 8, 1, 3),
]
KERNEL = re.compile(r"octolux::kernel::run::\w+")
TRAVERSAL = re.compile(r"octolux::kernel::rays::<impl octolux::kernel::world::World>::(closest|occluded)(_many)?(?!\w)")


def run(command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stderr.strip()[-2000:]}")
    return done.stdout


def build():
    run(["cargo", "build", "--release", "--bin", "octolux", "--target-dir", ROOT / "target/callgrind"],
        cwd=ROOT, env={**os.environ, "RUSTFLAGS": FLAGS})
    return ROOT / "target/callgrind/release/octolux"


def stripped(binary, folder):
    """A copy without line tables, by which valgrind would split functions that have code inlined from several files."""
    copy = folder / "octolux"
    run(["strip", "--strip-debug", "-o", copy, binary])
    return copy


def count(binary, scene, side, samples):
    """Instructions of the kernel and of traversal, paths and rays."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        out, image, report = folder / "callgrind.out", folder / "image.exr", folder / "report.json"
        run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", binary, "render", ROOT / "scenes" / scene,
             "-o", image, "--size", f"{side}x{side}", "--spp", samples, "--threads", 1, "--lanes", 8, "--seed", 1,
             "--sampler", "independent", "--path-reuse", "off", "--quiet", "--json", report])
        lines = run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", "--show-percs=no", out]).splitlines()
        report = json.loads(report.read_text())
    kernel = traversal = 0
    for line in lines:
        match = re.match(r"\s*([\d,]+)\s+(.*)$", line)
        if not match:
            continue
        instructions, name = int(match[1].replace(",", "")), match[2]
        if KERNEL.search(name):
            kernel += instructions
        elif TRAVERSAL.search(name):
            traversal += instructions
    rays = report["rays"]
    return {"kernel": kernel, "traversal": traversal, "paths": report["paths"],
            "rays": rays["camera_rays"] + rays["bounce_rays"] + rays["shadow_rays"]}


def measure(binary, scene, side, low, high):
    few, many = count(binary, scene, side, low), count(binary, scene, side, high)
    for part in ("kernel", "traversal"):
        if few[part] == 0:
            sys.exit(f"{scene}: no {part} among the symbols; see {part.upper()} in tools/callgrind.py")
    more = {key: many[key] - few[key] for key in few}
    return {"per_path": more["kernel"] / more["paths"], "per_ray": more["traversal"] / more["rays"],
            "rays_per_path": more["rays"] / more["paths"]}


def change(now, before):
    return "" if before is None else f"{100 * (now / before - 1):+8.2f} %"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--octolux", type=pathlib.Path, help="an x86-64-v3 build [default: one is made in target/callgrind]")
    parser.add_argument("--record", action="store_true", help=f"write {BASELINE.relative_to(ROOT)}")
    parser.add_argument("--only", default="", help="scenes whose name holds this")
    args = parser.parse_args()
    if args.record and args.only:
        parser.error("--record takes all scenes: leave --only out")
    binary = args.octolux or build()
    known = json.loads(BASELINE.read_text()) if BASELINE.exists() else {}
    found = {}
    print(f"{'':38} {'instr./path':>12} {'':10} {'instr./ray':>11} {'':10} {'rays/path':>9}")
    with tempfile.TemporaryDirectory() as folder:
        binary = stripped(binary, pathlib.Path(folder))
        for name, scene, side, low, high in SCENES:
            if args.only not in name:
                continue
            now, before = measure(binary, scene, side, low, high), known.get(name)
            found[name] = now
            changes = [change(now[key], before and before[key]) for key in ("per_path", "per_ray")]
            print(f"{name:38} {now['per_path']:12.1f} {changes[0]:>10} {now['per_ray']:11.1f} {changes[1]:>10} "
                  f"{now['rays_per_path']:9.3f}", flush=True)
    if args.record:
        BASELINE.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
