#!/usr/bin/env python3
"""Seconds and paths that octolux needs to a relMSE on the reference scenes, beside what its peers were measured to need.

    cargo build --release
    python3 tools/time_to_error.py [--seeds 4] [--scenes cornell,env] [--adaptive] [--json FILE] [-o DIR]

Runs `octolux converge` on each scene of ../shared/refs (reports stay in DIR) and prints a Markdown table with 95 %
intervals: rendering alone, and the wall clock from exec to closed file. The peers' seconds are those of
../shared/refs/README.md, measured on another machine; tools/peer_mitsuba.py re-measures Mitsuba's paths a second here, and
its paths to the error follow from C = relMSE·samples, which no machine changes. With --adaptive, samples are divided by a
pilot (whose paths and seconds count).
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
REFS = ROOT.parent / "shared" / "refs"
# Budgets, targets of relMSE with the best peer's seconds there, and Mitsuba's C with independent samples.
SCENES = {
    "cornell": ("4,16,64,256,1024", {1e-3: 1.7, 1e-4: 13.0}, 0.273),
    "cornell_direct": ("4,16,64,256,1024", {1e-5: 0.5}, 0.023),
    "veach_mis": ("4,16,64,256,1024", {1e-4: 2.0}, 0.438),
    "env": ("4,16,64,256,1024", {1e-3: 1.1, 1e-4: 8.0}, 0.298),
    "glass": ("16,64,256,1024", {1e-3: 43.0}, 2.65),
    "many_lights": ("1,4,16,64,256", {1e-2: 67.0}, 17.9),
    "door_ajar": ("16,64,256,1024", {1e-2: 14.0}, 24.9),
}


def measure(scene, budgets, arguments):
    folder = pathlib.Path(arguments.output) / scene
    command = [str(ROOT / "target" / "release" / "octolux"), "converge", str(REFS / scene / "scene.toml"),
               "--reference", str(REFS / f"{scene}.exr"), "--spp", budgets, "--seeds", str(arguments.seeds), "--quiet",
               "-o", str(folder)] + (["--", "--adaptive"] if arguments.adaptive else [])
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr.strip()}")
    return json.loads((folder / "report.json").read_text())


def cell(reached):
    if reached is None:
        return "–"
    mark = "*" if reached["extrapolated"] else ""
    bounds = f" ({reached['lo']:.3g}–{reached['hi']:.3g})" if reached["lo"] and reached["hi"] else ""
    return f"{reached['budget']:.3g}{mark}{bounds}"


def beyond_reports(report, relmse):
    """For a target that reports do not have: the straight line in logarithms between the budgets around it."""
    rows = report["variants"][0]["rows"]
    for before, after in zip(rows, rows[1:]):
        high, low = before["relmse"]["value"], after["relmse"]["value"]
        if high >= relmse >= low > 0:
            t = math.log(high / relmse) / math.log(high / low)

            def between(value):
                a, b = value(before), value(after)
                return {"budget": a * (b / a) ** t, "lo": None, "hi": None, "extrapolated": False}

            return {"relmse": relmse, "paths": between(lambda row: row["paths"]),
                    "seconds": between(lambda row: row["seconds"]["value"]),
                    "wall_seconds": between(lambda row: row["wall_seconds"]["value"])}
    return {"relmse": relmse, "paths": None, "seconds": None, "wall_seconds": None}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--adaptive", action="store_true", help="with samples divided by a pilot")
    parser.add_argument("--json", help="write the table as JSON too")
    parser.add_argument("-o", "--output", default=tempfile.mkdtemp(prefix="octolux-time-to-error-"))
    arguments = parser.parse_args()
    rows = []
    print("| scene | relMSE | s, rendering | s, exec to file | paths | of Mitsuba's paths | best peer, about, s |")
    print("|---|---|---|---|---|---|---|")
    for scene in arguments.scenes.split(","):
        budgets, targets, c = SCENES[scene]
        report = measure(scene, budgets, arguments)
        pixels = report["width"] * report["height"]
        stated = report["variants"][0]["targets"]
        for relmse, peer in targets.items():
            near = [t for t in stated if abs(t["relmse"] / relmse - 1) < 1e-6]
            target = near[0] if near else beyond_reports(report, relmse)
            paths = target["paths"]
            share = f"1/{c / target['relmse'] * pixels / paths['budget']:.3g}" if paths else "–"
            print(f"| {scene} | {target['relmse']:g} | {cell(target['seconds'])} | {cell(target['wall_seconds'])} "
                  f"| {cell(paths)} | {share} | {peer:g} |", flush=True)
            rows.append({"scene": scene, "best_peer_seconds": peer, "mitsuba_c": c, **target})
    print("\n* extrapolated beyond the budgets.  Reports:", arguments.output)
    if arguments.json:
        machine = {"machine": report["machine"], "seeds": arguments.seeds, "rows": rows}
        pathlib.Path(arguments.json).write_text(json.dumps(machine, indent=1) + "\n")


if __name__ == "__main__":
    main()
