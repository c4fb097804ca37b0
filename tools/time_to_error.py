#!/usr/bin/env python3
"""Seconds and paths that octolux needs to a relMSE on the reference scenes, beside what its peers were measured to need.

    cargo build --release
    python3 tools/time_to_error.py [--seeds 4] [--scenes cornell,env] [--adaptive | --without | --mitsuba]
                                   [--references DIR] [--json FILE] [-o DIR]

Runs `octolux converge` on each scene of ../shared/refs (reports stay in DIR) and prints a Markdown table with 95 %
intervals: rendering alone, and the wall clock from exec to closed file (what is not rendering is the median of seven starts
of `octolux render`). The peers' seconds are those of
../shared/refs/README.md, measured on another machine; tools/peer_mitsuba.py re-measures Mitsuba's paths a second here, and
its paths to the error follow from C = relMSE·samples, which no machine changes. With --mitsuba, where that is
installed, its seconds are measured here, too: renders by its best sampler (multi-jittered), half of the seeds before ours
and half after. With --adaptive, samples are divided by a pilot (whose paths and seconds count). With --without, the same by
renders that go without one of what makes the difference, and without all: seconds from exec to file, and how many times as
many that is.
"""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
REFS = ROOT.parent / "shared" / "refs"
# Budgets, targets of relMSE with the best peer's seconds there, and Mitsuba's C with independent samples.
SCENES = {
    "cornell": ("4,8,16,64,256,1024", {1e-3: 1.7, 1e-4: 13.0}, 0.273),
    "cornell_direct": ("4,16,64,256,1024", {1e-5: 0.5}, 0.023),
    "veach_mis": ("4,16,64,256,1024", {1e-4: 2.0}, 0.438),
    "env": ("4,8,16,64,256,1024", {1e-3: 1.1, 1e-4: 8.0}, 0.298),
    "glass": ("16,64,256,1024", {1e-3: 43.0}, 2.65),
    "many_lights": ("1,4,16,64,256", {1e-2: 67.0}, 17.9),
    "door_ajar": ("16,64,256,1024", {1e-2: 14.0}, 24.9),
}
# Samples a pixel for Mitsuba; what takes long to get there is judged from less.
MITSUBA = {
    "cornell": "16,64,256,1024",
    "cornell_direct": "16,64,256",
    "veach_mis": "64,256,1024",
    "env": "64,256,1024",
    "glass": "64,256",
    "many_lights": "64,256",
    "door_ajar": "64,256,1024",
}
# What can be left out, by the flags that do.
WITHOUT = {
    "as it is": "",
    "samples divided": "--adaptive",
    "independent numbers": "--sampler independent",
    "own paths": "--path-reuse off",
    "no light paths": "--light-paths off",
    "peers' roulette": "--roulette 5,1",
    "none of it": "--sampler independent --path-reuse off --light-paths off --roulette 5,1",
}


def measure(scene, budgets, arguments, variants=()):
    folder = pathlib.Path(arguments.output) / scene
    command = [str(ROOT / "target" / "release" / "octolux"), "converge", str(REFS / scene / "scene.toml"),
               "--reference", str(pathlib.Path(arguments.references) / f"{scene}.exr"), "--spp", budgets, "--seeds", str(arguments.seeds), "--quiet",
               "-o", str(folder)]
    if variants:
        command += ["--variants", "; ".join(f"{name}: {WITHOUT[name]}" for name in variants)]
    command += ["--", "--adaptive"] if arguments.adaptive else []
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr.strip()}")
    return json.loads((folder / "report.json").read_text())


def starts(scene, adaptive, count=7):
    """Seconds from exec to closed file that are not rendering: the median over so many starts of `octolux render`."""
    command = [str(ROOT / "target" / "release" / "octolux"), "render", str(REFS / scene / "scene.toml"), "--spp", "8", "--quiet",
               "--json", "-", *(["--adaptive"] if adaptive else [])]
    with tempfile.TemporaryDirectory() as folder:
        reports = []
        for _ in range(count):
            done = subprocess.run([*command, "-o", f"{folder}/image.exr"], capture_output=True, text=True, check=True)
            reports.append(json.loads(done.stdout))
    return statistics.median(report["wall_seconds"] - report["render_seconds"] for report in reports)


def mitsuba(scene, seeds, arguments):
    """The rows of so many seeds of Mitsuba's, and the seconds of its process that are not rendering."""
    command = [sys.executable, str(ROOT / "tools" / "peer_mitsuba.py"), str(REFS / scene / "scene.toml"),
               "--reference", str(pathlib.Path(arguments.references) / f"{scene}.exr"), "--sampler", "multijitter",
               "--budgets", MITSUBA[scene], "--seeds", ",".join(map(str, seeds))]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: {done.stderr.strip()}")
    head, *rows = map(json.loads, done.stdout.splitlines())
    return rows, head["beside_rendering_seconds"]


def seconds_of_mitsuba(rows, floor, relmse):
    """Its seconds of rendering to a relMSE: the mean of the seeds' logarithms, with a 95 % interval (Student's t)."""
    logs, extrapolated = [], False
    for seed in sorted({row["seed"] for row in rows}):
        curve = [(row["seconds"], row["relmse"] - floor) for row in rows if row["seed"] == seed]
        steps = [(a, b) for a, b in zip(curve, curve[1:]) if a[1] > b[1] > 0]
        if not steps:
            return None
        # The line through the budgets on both sides, or the nearest two.
        nearest = steps[0] if relmse > steps[0][0][1] else steps[-1]
        (s, e), (t, f) = next((step for step in steps if step[0][1] >= relmse >= step[1][1]), nearest)
        extrapolated |= not e >= relmse >= f
        logs.append(math.log(s) + math.log(t / s) * math.log(e / relmse) / math.log(e / f))
    quantile = {2: 12.7, 3: 4.30, 4: 3.18, 5: 2.78, 6: 2.57, 7: 2.45, 8: 2.36}.get(len(logs), 2.3)
    half = quantile * statistics.stdev(logs) / math.sqrt(len(logs)) if len(logs) > 1 else None
    mean = statistics.mean(logs)
    return {"budget": math.exp(mean), "lo": half and math.exp(mean - half), "hi": half and math.exp(mean + half),
            "extrapolated": extrapolated}


def beside_rendering(reached, seconds):
    """What was reached so many seconds later."""
    return {key: value + seconds if key in ("budget", "lo", "hi") and value else value for key, value in reached.items()}


def cell(reached):
    if reached is None:
        return "–"
    mark = "*" if reached["extrapolated"] else ""
    bounds = f" ({reached['lo']:.3g}–{reached['hi']:.3g})" if reached["lo"] and reached["hi"] else ""
    return f"{reached['budget']:.3g}{mark}{bounds}"


def target_of(variant, relmse):
    """What a variant's report says of a target."""
    near = [t for t in variant["targets"] if abs(t["relmse"] / relmse - 1) < 1e-6]
    return near[0] if near else beyond_reports(variant, relmse)


def beyond_reports(variant, relmse):
    """For a target that reports do not have: the straight line in logarithms between the budgets around it, or the last two."""
    pairs = [(a, b) for a, b in zip(variant["rows"], variant["rows"][1:]) if a["relmse"]["value"] > b["relmse"]["value"] > 0]
    around = [pair for pair in pairs if pair[0]["relmse"]["value"] >= relmse >= pair[1]["relmse"]["value"]]
    if not (around or pairs) or not around and relmse > pairs[-1][1]["relmse"]["value"]:
        return {"relmse": relmse, "paths": None, "seconds": None, "wall_seconds": None}
    before, after = around[0] if around else pairs[-1]
    t = math.log(before["relmse"]["value"] / relmse) / math.log(before["relmse"]["value"] / after["relmse"]["value"])

    def between(value):
        a, b = value(before), value(after)
        return {"budget": a * (b / a) ** t, "lo": None, "hi": None, "extrapolated": not around}

    return {"relmse": relmse, "paths": between(lambda row: row["paths"]),
            "seconds": between(lambda row: row["seconds"]["value"]),
            "wall_seconds": between(lambda row: row["wall_seconds"]["value"])}


def without(scene, arguments):
    """A row a target: seconds by each variant, and over those of a render as it is."""
    budgets, targets, _ = SCENES[scene]
    # Light paths are planned where there is glass; glass has no path reuse.
    idle = "own paths" if scene == "glass" else "no light paths"
    # What takes long to get there is judged from less: its straight line goes on.
    report = measure(scene, ",".join(budgets.split(",")[:-1]), arguments, [name for name in WITHOUT if name != idle])
    rows = []
    for relmse in targets:
        cells, first = [], None
        for name in WITHOUT:
            variant = next((v for v in report["variants"] if v["name"] == name), None)
            reached = target_of(variant, relmse)["wall_seconds"] if variant else None
            first = first or (reached and reached["budget"])
            cells.append(cell(reached) + (f", ×{reached['budget'] / first:.3g}" if reached and first else ""))
        print(f"| {scene} | {relmse:g} | " + " | ".join(cells) + " |", flush=True)
        rows.append({"scene": scene, "relmse": relmse, "wall_seconds": dict(zip(WITHOUT, cells))})
    return report, rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--references", default=str(REFS), help="where NAME.exr and NAME.json are [default: ../shared/refs]")
    parser.add_argument("--adaptive", action="store_true", help="with samples divided by a pilot")
    parser.add_argument("--without", action="store_true", help="what each ingredient is worth")
    parser.add_argument("--mitsuba", action="store_true", help="measure Mitsuba's seconds here, too")
    parser.add_argument("--json", help="write the table as JSON too")
    parser.add_argument("-o", "--output", default=tempfile.mkdtemp(prefix="octolux-time-to-error-"))
    arguments = parser.parse_args()
    if arguments.without and (arguments.adaptive or arguments.mitsuba):
        sys.exit("--without has --adaptive among what it compares, and no peers; leave the other out")
    rows = []
    if arguments.without:
        print("| scene | relMSE | " + " | ".join(WITHOUT) + " |\n|" + "---|" * (2 + len(WITHOUT)))
        for scene in arguments.scenes.split(","):
            report, found = without(scene, arguments)
            rows += found
        write(arguments, report, rows)
        return
    head = ["scene", "relMSE", "s, rendering", "s, exec to file", "paths", "of Mitsuba's paths"]
    head += ["Mitsuba, s, rendering", "s, exec to file", "ours of these"] if arguments.mitsuba else ["best peer, about, s"]
    print(f"| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for scene in arguments.scenes.split(","):
        report, found = beside_peers(scene, arguments)
        rows += found
    write(arguments, report, rows)


def beside_peers(scene, arguments):
    """A row a target: what octolux needs, and what peers do."""
    budgets, targets, c = SCENES[scene]
    before = mitsuba(scene, range(0, arguments.seeds, 2), arguments) if arguments.mitsuba else None
    report = measure(scene, budgets, arguments)
    after = mitsuba(scene, range(1, max(arguments.seeds, 2), 2), arguments) if arguments.mitsuba else None
    beside = starts(scene, arguments.adaptive)
    floor = json.loads((pathlib.Path(arguments.references) / f"{scene}.json").read_text())["relmse_floor"]
    pixels = report["width"] * report["height"]
    rows = []
    for relmse, peer in targets.items():
        target = target_of(report["variants"][0], relmse)
        target["wall_seconds"] = target["seconds"] and beside_rendering(target["seconds"], beside)
        paths = target["paths"]
        share = f"1/{c / target['relmse'] * pixels / paths['budget']:.3g}" if paths else "–"
        cells = [scene, f"{target['relmse']:g}", cell(target["seconds"]), cell(target["wall_seconds"]), cell(paths), share]
        row = {"scene": scene, "best_peer_seconds": peer, "mitsuba_c": c, **target}
        if arguments.mitsuba:
            theirs = seconds_of_mitsuba(before[0] + after[0], floor, relmse)
            wall = theirs and beside_rendering(theirs, min(before[1], after[1]))
            ratio = f"1/{wall['budget'] / target['wall_seconds']['budget']:.3g}" if wall and target["wall_seconds"] else "–"
            cells += [cell(theirs), cell(wall), ratio]
            row |= {"mitsuba_seconds": theirs, "mitsuba_wall_seconds": wall, "mitsuba_rows": [before, after]}
        else:
            cells.append(f"{peer:g}")
        print(f"| {' | '.join(cells)} |", flush=True)
        rows.append(row)
    return report, rows


def write(arguments, report, rows):
    print("\n* extrapolated beyond the budgets.  Reports:", arguments.output)
    if arguments.json:
        machine = {"machine": report["machine"], "seeds": arguments.seeds, "rows": rows}
        pathlib.Path(arguments.json).write_text(json.dumps(machine, indent=1) + "\n")


if __name__ == "__main__":
    main()
