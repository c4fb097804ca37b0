#!/usr/bin/env python3
"""Rays per second against Embree 3 on the same files of triangles and rays, one pinned thread, programs in turn.

    apt-get install g++ libembree-dev
    python3 tools/compare_embree.py [SCENE ...] [--peers ../shared/peers/rays] [--models ../shared/models]
                                    [--scratch DIR] [--rounds 5] [--core 0] [--out benches/results] [--paths SCENE.toml ...]

Builds the peer's programs and makes its data in the scratch folder unless they are there. Embree's best setting of each
cell (instruction set, packet width, coherence flag) is found in one survey; then octolux and that setting are timed
alternately. Embree runs with robust=0 for speed; hits and the sum of t are compared with its robust=1. `--paths` adds
camera paths per second against Mitsuba 3 where that is installed (tools/peer_mitsuba.py). Writes DATE.json and DATE.md.
"""
import argparse
import datetime
import json
import pathlib
import platform
import re
import statistics
import subprocess
import sys

SETS = ["P", "B1", "B2", "S", "A"]
RAY_LINE = re.compile(r"^\S+\s+\S+\s+(\S+)\s+(\S+)\s+T1\s+([\d.]+) Mrays/s.*hits (\d+)/(\d+) sumt (\S+)$")
BUILD_LINE = re.compile(r"^build \S+ \S+ ([\d.]+) s .*?([\d.]+) B/tri ")


def run(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stderr.strip()}")
    return done.stdout


def prepare(args, scenes):
    """The peer's programs and data; what is there already stays."""
    data = args.scratch / "data"
    data.mkdir(parents=True, exist_ok=True)
    for name, optimise, libraries in [
        ("gen_scenes", "-O2", []),
        ("gen_rays", "-O2", ["-lembree3"]),
        ("embree_bench", "-O3", ["-lembree3", "-lpthread"]),
    ]:
        if not (args.scratch / name).exists():
            source = args.peers / f"{name}.cpp"
            run(["g++", optimise, "-march=native", source, *libraries, "-o", args.scratch / name])
    if any(not (data / f"{scene}.tri").exists() for scene in scenes):
        run([args.scratch / "gen_scenes", data, args.models, args.models / "kitchen.obj"])
    for scene in scenes:
        if not (data / f"{scene}.A.rays").exists():
            run([args.scratch / "gen_rays", data, scene])
    return data


def embree(args, base, isa, sets, methods, runs, **options):
    """(build seconds, bytes a triangle, [(set, method, Mrays/s, hits, sum of t)])."""
    words = [f"{key}={value}" for key, value in options.items()]
    out = run(["taskset", "-c", args.core, args.scratch / "embree_bench", base, f"isa={isa}", "threads=1",
               f"sets={','.join(sets)}", f"methods={','.join(methods)}", f"runs={runs}", *words])
    build, rays = None, []
    for line in out.splitlines():
        if match := BUILD_LINE.match(line):
            build = float(match[1]), float(match[2])
        elif match := RAY_LINE.match(line):
            rays.append((match[1], match[2], float(match[3]), int(match[4]), float(match[6])))
    if build is None:
        sys.exit(f"embree_bench printed no build line:\n{out}")
    return *build, rays


def octolux(args, base, sets, windows):
    out = run(["taskset", "-c", args.core, args.octolux, "bench", "rays", base, "--sets", ",".join(sets),
               "--windows", windows, "--json", "-"])
    return json.loads(out)


def compare(args, base):
    """One scene: the survey, then alternation."""
    best = {}
    for isa in instruction_sets():
        for name, method, rate, _, _ in embree(args, base, isa, SETS, ["1", "8", "8c", "16", "16c"], 1)[2]:
            best[name] = max(best.get(name, (0.0, "", "")), (rate, isa, method))
    *_, robust = embree(args, base, "avx2", SETS, ["1"], 1, robust=1)
    ours, theirs = {name: [] for name in best}, {name: [] for name in best}
    for _ in range(args.rounds):
        report = octolux(args, base, list(best), 3)
        for row in report["sets"]:
            ours[row["set"]].append(row["mrays_per_s"])
        for name, (_, isa, method) in best.items():
            theirs[name] += [row[2] for row in embree(args, base, isa, [name], [method], 3)[2]]
    sets = []
    for row in report["sets"]:
        name = row["set"]
        ratios = [a / b for a, b in zip(ours[name], theirs[name])]
        hits, sum_t = next((r[3], r[4]) for r in robust if r[0] == name)
        sets.append({
            "set": name, "lanes": row["lanes"], "mode": row["mode"], "embree": f"{best[name][1]} {best[name][2]}",
            "octolux_mrays": statistics.median(ours[name]), "embree_mrays": statistics.median(theirs[name]),
            "ratio": statistics.median(ratios), "ratio_min": min(ratios), "ratio_max": max(ratios),
            "rays": row["rays"], "hits": row["hits"], "hits_robust": hits,
            "sum_t": row["sum_t"], "sum_t_robust": sum_t,
        })
    # Builds: both programs are pinned to the one core here.
    medium, bytes_embree, _ = embree(args, base, "avx2", ["P"], ["1"], 1, quality="medium", limit=16)
    build = report["build"]
    return {
        "scene": report["scene"], "triangles": report["triangles"], "sets": sets,
        "build_seconds": build["seconds"], "build_seconds_embree_medium": medium,
        "bytes_per_triangle": (build["node_bytes"] + build["block_bytes"]) / report["triangles"],
        "bytes_per_triangle_embree": bytes_embree,
    }


def paths(args, scene):
    """Camera paths per second, two threads, in turn; `None` where Mitsuba is not installed."""
    if subprocess.run([sys.executable, "-c", "import mitsuba"], capture_output=True).returncode != 0:
        return None
    ours, theirs = [], []
    for _ in range(args.rounds):
        ours.append(json.loads(run([args.octolux, "bench", scene, "--roulette", "5,1", "--path-reuse", "off", "--threads", 2,
                                    "--windows", 3, "--json", "-"])))
        peer = pathlib.Path(__file__).with_name("peer_mitsuba.py")
        theirs.append(json.loads(run([sys.executable, peer, scene, "--windows", 3, "--threads", 2])))
    return {"scene": str(scene), "octolux": ours, "mitsuba": theirs}


def markdown(report):
    lines = [
        f"{report['date']}, {report['cpu']}, one pinned thread, {report['rounds']} alternations. Million rays a second,"
        " octolux / Embree's best, and the ratio, median (min–max).", "",
        "| | " + " | ".join(SETS) + " |", "|---|" + "---|" * len(SETS),
    ]
    for scene in report["scenes"]:
        by_name = {s["set"]: s for s in scene["sets"]}
        cells = []
        for name in SETS:
            s = by_name.get(name)
            cells.append("–" if s is None else f"{s['octolux_mrays']:.1f} / {s['embree_mrays']:.1f}: **{s['ratio']:.2f}** "
                         f"({s['ratio_min']:.2f}–{s['ratio_max']:.2f})")
        lines.append(f"| {scene['scene']} | " + " | ".join(cells) + " |")
    lines += ["", "| | hits that differ from robust Embree, of all rays | Σt, relative | build s, octolux / Embree MEDIUM |"
              " bytes a triangle |", "|---|---|---|---|---|"]
    for scene in report["scenes"]:
        differ = ", ".join(f"{s['set']} {s['hits'] - s['hits_robust']:+d}" for s in scene["sets"])
        off = [abs(s["sum_t"] / s["sum_t_robust"] - 1) for s in scene["sets"] if s["sum_t_robust"]]
        lines.append(f"| {scene['scene']} | {differ} | {max(off, default=0):.0e} | {scene['build_seconds']:.3f} / "
                     f"{scene['build_seconds_embree_medium']:.3f} | {scene['bytes_per_triangle']:.0f} / "
                     f"{scene['bytes_per_triangle_embree']:.0f} |")
    return "\n".join(lines) + "\n"


def instruction_sets():
    """What this CPU can run of what Embree is compiled for."""
    info = pathlib.Path("/proc/cpuinfo")
    wide = info.exists() and "avx512dq" in info.read_text()
    return ["avx2", "avx512"] if wide else ["avx2"]


def cpu_name():
    info = pathlib.Path("/proc/cpuinfo")
    names = re.findall(r"^model name\s*: (.*)$", info.read_text(), re.M) if info.exists() else []
    families = re.findall(r"^cpu family\s*: (.*)$", info.read_text(), re.M) if info.exists() else []
    return f"{names[0]} (family {families[0]})" if names and families else platform.processor()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["cornell", "kitchen", "ogre", "terrain"])
    for option, default in [("--peers", "../shared/peers/rays"), ("--models", "../shared/models"),
                            ("--scratch", "target/compare"), ("--out", "benches/results"),
                            ("--octolux", "target/release/octolux")]:
        parser.add_argument(option, type=pathlib.Path, default=pathlib.Path(default))
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--core", type=int, default=0)
    parser.add_argument("--paths", nargs="*", type=pathlib.Path, default=[])
    args = parser.parse_args()
    data = prepare(args, args.scenes)
    report = {
        "date": datetime.date.today().isoformat(), "cpu": cpu_name(), "rounds": args.rounds,
        "scenes": [compare(args, data / scene) for scene in args.scenes],
        "paths": [found for found in (paths(args, scene) for scene in args.paths) if found],
    }
    args.out.mkdir(parents=True, exist_ok=True)
    text = markdown(report)
    (args.out / f"{report['date']}.json").write_text(json.dumps(report, indent=1) + "\n")
    (args.out / f"{report['date']}.md").write_text(text)
    print(text, end="")


if __name__ == "__main__":
    main()
