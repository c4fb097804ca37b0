#!/usr/bin/env python3
"""Camera paths per second against a path tracer on Embree 3 (tools/embree_path_tracer), programs in turn.

    apt-get install g++ libembree-dev; pip install mitsuba numpy     # mitsuba reads the environment's image
    python3 tools/peer_embree.py [SCENE.toml | kitchen ...] [--octolux target/release/octolux] [--rounds 5] [--json FILE]

The peer has the same rules (one light sample by power and one material sample a vertex, power heuristic, roulette from the
fifth event), waves of 512 paths, robust=0. Both have 16 lanes, 8 where there is no AVX-512. The peer's best setting
(instruction set, packets of 16 or 8, or single rays) is found in one survey; then `octolux bench` and that setting are timed
alternately on the same two cores. Image means of the two are compared in the peer's own windows: `off` is in standard
errors of the difference. `--cpu`, for a machine that others use too: user seconds of one thread, of many samples less
those of few, in turn.
Of materials it knows diffuse and conductor with eta and k; triangles are flat. `kitchen`: ../shared/models/kitchen.obj, flat, each
material diffuse with its Kd, under a panel of light, 512 x 512.
"""
import argparse
import json
import pathlib
import resource
import statistics
import struct
import subprocess
import sys
import tempfile
import tomllib

import numpy as np

from compare_embree import instruction_sets
from peer_mitsuba import parse_obj

HERE = pathlib.Path(__file__).parent
WIDE = instruction_sets()[-1]
LANES = 16 if WIDE == "avx512" else 8
SHARED = HERE.parent.parent / "shared"


def kitchen(folder):
    """A scene file for the kitchen that both programs can read."""
    model = SHARED / "models" / "kitchen.obj"
    names, text = {}, []
    for line in open(model.with_suffix(".mtl")):
        words = line.split()
        if words[:1] == ["newmtl"]:
            current = words[1]
        elif words[:1] == ["Kd"]:
            names[current] = [float(x) for x in words[1:4]]
    (folder / "panel.obj").write_text(
        "v -.27 2.3 -.96\nv 1.95 2.3 -.96\nv 1.95 2.3 1.07\nv -.27 2.3 1.07\nusemtl panel\nf 1 2 3\nf 1 3 4\n")
    text.append(f'''[camera]
position = [3.3, 1.5, 0.0567]
look_at = [0.84, 1.5, 0.0567]
up = [0, 1, 0]
vfov = 60
[film]
width = 512
height = 512
[integrator]
kind = "path"
max_bounces = 7
[[mesh]]
file = "{model.resolve()}"
flat = true
[[mesh]]
file = "panel.obj"
[materials.panel]
type = "diffuse"
reflectance = [0, 0, 0]
emission = [2, 2, 2]
''')
    for name, colour in names.items():
        text.append(f'[materials."{name}"]\ntype = "diffuse"\nreflectance = {colour}\n')
    path = folder / "kitchen.toml"
    path.write_text("\n".join(text))
    return path


def sky(scene, folder):
    """(h, w, 4) radiance of the environment; nothing where there is none."""
    if "environment" not in scene:
        return np.zeros((0, 0, 4), np.float32)
    if "file" not in scene["environment"]:
        return np.ones((4, 8, 4), np.float32) * np.float32([*scene["environment"]["radiance"], 0])
    import mitsuba
    mitsuba.set_variant("scalar_rgb")
    image = np.array(mitsuba.Bitmap(str(folder / scene["environment"]["file"])), np.float32)[..., :3]
    return np.concatenate([image, np.zeros_like(image[..., :1])], axis=2)


def flatten(path, out):
    """Writes the scene as the C++ program reads it: int32 and float32, see load_scene."""
    scene = tomllib.load(open(path, "rb"))
    camera, film = scene["camera"], scene["film"]
    names = list(scene["materials"])
    vertices, faces, owners = [], [], []
    for mesh in scene["mesh"]:
        points, groups = parse_obj(path.parent / mesh["file"])
        for name, triangles in groups.items():
            faces += [[len(vertices) + v for v in t] for t in triangles]
            owners += [names.index(name)] * len(triangles)
        vertices += points
    if "sphere" in scene:
        sys.exit(f"{path}: the peer has no spheres")
    columns = np.zeros((13, len(names)), np.float32)
    kinds = np.zeros(len(names), np.int32)
    for i, name in enumerate(names):
        m = scene["materials"][name]
        if m["type"] == "diffuse":
            columns[0:3, i] = m["reflectance"]
        elif m["type"] == "conductor" and m.get("alpha", 0) > 0 and "eta" in m:
            kinds[i] = 1
            columns[6, i], columns[7:10, i], columns[10:13, i] = m["alpha"], m["eta"], m["k"]
        else:
            sys.exit(f"{path}: material {name} is none that the peer knows")
        columns[3:6, i] = m.get("emission", [0, 0, 0])
    position, target, up = (np.array(camera[k], float) for k in ["position", "look_at", "up"])
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    slope = np.tan(np.radians(camera["vfov"]) / 2)
    views = [position, forward, right * slope * film["width"] / film["height"], np.cross(right, forward) * slope]
    image = sky(scene, path.parent)
    head = [film["width"], film["height"], scene["integrator"]["max_bounces"], len(vertices), len(faces), len(names),
            image.shape[1], image.shape[0]]
    with open(out, "wb") as file:
        file.write(struct.pack("8i", *head))
        for block, kind in [(views, np.float32), (vertices, np.float32), (faces, np.int32), (owners, np.int32),
                            (kinds, np.int32), (columns, np.float32), (image, np.float32)]:
            file.write(np.ascontiguousarray(block, kind).tobytes())


def run(command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stderr.strip()}")
    return done.stdout


def peer(program, scene, setting, **options):
    words = [w for pair in {**setting, **options}.items() for w in (f"--{pair[0]}", pair[1])]
    return json.loads(run([program, scene, *words]))


def samples_for(program, scene, setting, seconds):
    """A window of at least so many seconds."""
    pixels = struct.unpack("2i", open(scene, "rb").read(8))
    rate = peer(program, scene, setting, spp=4, windows=1)["mpaths_per_s"]
    return max(1, round(1e6 * rate * seconds / (pixels[0] * pixels[1])))


def user_seconds(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    run(command)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def by_cpu(args, path, program, binary):
    """Million paths per user second, by round: ours, and of each of the peer's settings (with the widest instructions)."""
    pixels = int(np.prod(struct.unpack("2i", open(binary, "rb").read(8))))
    low, high = (max(1, round(n * 65536 / pixels)) for n in (8, 40))
    image = args.scratch / "cpu.exr"

    def ours(spp):
        return user_seconds([args.octolux, "render", path, "-o", image, "--roulette", "5,1", "--path-reuse", "off", "--threads", 1, "--lanes", LANES, "--quiet",
                             "--spp", spp])

    def theirs(spp, bounce, shadow):
        # Its first window warms up and is as long as the others: two in all.
        return user_seconds([program, binary, "--threads", 1, "--windows", 1, "--bounce", bounce, "--shadow", shadow,
                             "--spp", spp]) / 2

    settings = [(1, 8), (8, 8)] + [(1, 16), (8, 16), (16, 16)] * (LANES == 16)
    rates = []
    for _ in range(args.rounds):
        seconds = [ours(high) - ours(low)] + [theirs(high, *s) - theirs(low, *s) for s in settings]
        rates.append([1e-6 * pixels * (high - low) / s for s in seconds])
    return rates, settings


def survey(program, scene):
    """The setting with the most paths a second."""
    first = {"isa": WIDE, "bounce": LANES, "shadow": LANES}
    spp = samples_for(program, scene, first, 0.3)
    rates = []
    for isa in instruction_sets():
        widths = [1, 8] if isa == "avx2" else [1, 8, 16]
        for bounce in widths:
            for shadow in widths:
                setting = {"isa": isa, "bounce": bounce, "shadow": shadow}
                rates.append((peer(program, scene, setting, spp=spp, windows=1)["mpaths_per_s"], setting))
    return max(rates, key=lambda pair: pair[0])[1], spp


def means(args, path, setting, program, binary):
    """Image means of both at many samples, and how far apart they are in standard errors over four renders each."""
    ours, theirs = [], []
    spp = max(1, round(128 * 65536 / int(np.prod(struct.unpack("2i", open(binary, "rb").read(8))))))
    for k in range(4):
        run([args.octolux, "render", path, "-o", args.scratch / "mean.exr", "--spp", spp, "--seed", 100 + k,
             "--sampler", "independent", "--quiet"])
        import mitsuba
        mitsuba.set_variant("scalar_rgb")
        pixels = np.array(mitsuba.Bitmap(str(args.scratch / "mean.exr")), np.float64)
        ours.append(pixels[..., :3].mean(axis=(0, 1)))
        theirs.append(peer(program, binary, setting, spp=spp, windows=1, seed=1 + 8 * k)["mean"])
    ours, theirs = np.array(ours), np.array(theirs)
    error = np.sqrt((ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / len(ours))
    return {"octolux": list(ours.mean(axis=0)), "embree": list(theirs.mean(axis=0)),
            "standard_error": list(error), "off": list((ours.mean(axis=0) - theirs.mean(axis=0)) / error)}


def compare(args, name, program):
    path = kitchen(args.scratch) if name == "kitchen" else pathlib.Path(name)
    binary = args.scratch / "scene.bin"
    flatten(path, binary)
    name = path.parent.name if path.stem == "scene" else path.stem
    if args.cpu:
        rates, settings = by_cpu(args, path, program, binary)
        medians = [statistics.median(column) for column in zip(*rates)]
        best = max(range(1, len(medians)), key=lambda k: medians[k])
        setting = dict(zip(("isa", "bounce", "shadow"), (WIDE, *settings[best - 1])))
        check = None if args.no_means else means(args, path, setting, program, binary)
        return result(name, setting, check, [(row[0], row[best]) for row in rates])
    setting, spp = survey(program, binary)
    check = None if args.no_means else means(args, path, setting, program, binary)
    rounds = []
    for _ in range(args.rounds):
        ours = json.loads(run([args.octolux, "bench", path, "--roulette", "5,1", "--path-reuse", "off", "--threads", 2, "--lanes", LANES, "--windows", 3,
                               "--json", "-"]))
        theirs = peer(program, binary, setting, spp=spp, windows=3)
        rounds.append((ours["settings"][0]["mpaths_per_s"], theirs["mpaths_per_s"]))
    return result(name, setting, check, rounds)


def result(name, setting, check, rounds):
    ratios = [a / b for a, b in rounds]
    return {"scene": name, "setting": setting, "means": check,
            "octolux_mpaths": [a for a, _ in rounds], "embree_mpaths": [b for _, b in rounds],
            "ratio": statistics.median(ratios), "ratio_min": min(ratios), "ratio_max": max(ratios)}


def main():
    refs = SHARED / "refs"
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=[refs / "cornell/scene.toml", refs / "env/scene.toml", "kitchen"])
    parser.add_argument("--octolux", default=HERE.parent / "target/release/octolux", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--cpu", action="store_true", help="compare user seconds of one thread instead of wall clock of two")
    parser.add_argument("--no-means", action="store_true", help="do not compare image means first")
    parser.add_argument("--scratch", type=pathlib.Path, help="folder for the program and its scene [default: a temporary one]")
    parser.add_argument("--json", type=pathlib.Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        args.scratch = args.scratch or pathlib.Path(folder)
        args.scratch.mkdir(parents=True, exist_ok=True)
        program = args.scratch / "embree_path_tracer"
        run(["g++", "-O3", "-march=native", "-std=c++20", "-ffast-math", "-fno-finite-math-only",
             HERE / "embree_path_tracer/main.cpp", "-lembree3", "-lpthread", "-o", program])
        results = []
        for name in args.scenes:
            r = compare(args, name, program)
            results.append(r)
            off = "" if r["means"] is None else " means off by " + ", ".join(f"{x:+.1f}" for x in r["means"]["off"]) + " standard errors"
            print(f"{r['scene']:10} {statistics.median(r['octolux_mpaths']):7.2f} / {statistics.median(r['embree_mpaths']):7.2f} "
                  f"Mpaths/{'CPU ' if args.cpu else ''}s: {r['ratio']:.2f} ({r['ratio_min']:.2f}-{r['ratio_max']:.2f}) {r['setting']}{off}", flush=True)
    if args.json:
        args.json.write_text(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
