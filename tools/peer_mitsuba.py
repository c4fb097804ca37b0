#!/usr/bin/env python3
"""Camera paths per second of Mitsuba 3 (llvm) on a scene.toml of ours, or its error against seconds, for comparison.

    pip install mitsuba numpy          # and an LLVM, on Debian: apt-get install libllvm19
    python3 tools/peer_mitsuba.py SCENE.toml [...] [--variant llvm_ad_rgb] [--windows 5] [--spp 64] [--threads 2]
    python3 tools/peer_mitsuba.py SCENE.toml --reference REF.exr --budgets 16,64,256 [--sampler multijitter] [--seeds 0,1]

Reads what the reference scenes use: OBJ meshes by usemtl, spheres, diffuse, conductor, dielectric, area emission
(lamps chosen by power), environment, pinhole camera. Prints JSON: median, minimum and maximum over the windows, each a
whole render of the already loaded and compiled scene; or, with --reference, a row for each seed and number of samples:
seconds of the render and relMSE against the reference (whose own noise is in it), and what the process took beside it.
"""
import argparse
import json
import os
import pathlib
import statistics
import sys
import tempfile
import time
import tomllib

STARTED = time.perf_counter()


def parse_obj(path):
    """Triangles by material: {name: (vertices, faces)}."""
    vertices, groups, current = [], {}, None
    for line in open(path):
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append([float(x) for x in words[1:4]])
        elif words[0] == "usemtl":
            current = groups.setdefault(words[1], [])
        elif words[0] == "f":
            corners = [int(w.split("/")[0]) for w in words[1:]]
            corners = [c - 1 if c > 0 else len(vertices) + c for c in corners]
            for i in range(1, len(corners) - 1):
                current.append([corners[0], corners[i], corners[i + 1]])
    return vertices, groups


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}



def bsdf(material):
    kind = material["type"]
    alpha = material.get("alpha", 0.0)
    if kind == "diffuse":
        return {"type": "twosided", "nested": {"type": "diffuse", "reflectance": rgb(material["reflectance"])}}
    if kind == "conductor":
        nested = {"type": "roughconductor", "alpha": alpha, "distribution": "ggx"} if alpha > 0 else {"type": "conductor"}
        if "eta" in material:
            nested |= {"eta": rgb(material["eta"]), "k": rgb(material["k"])}
        else:
            nested |= {"material": "none"}
        return {"type": "twosided", "nested": nested}
    if kind == "dielectric":
        nested = {"type": "roughdielectric", "alpha": alpha, "distribution": "ggx"} if alpha > 0 else {"type": "dielectric"}
        return nested | {"int_ior": float(material["ior"]), "ext_ior": 1.0}
    raise SystemExit(f"material type {kind} is not of the reference scenes")


def power(np, vertices, faces, radiance):
    """Of a lamp, up to a factor that all have: by it the reference's own renders of many lamps choose (refs/README.md)."""
    corners = np.array([[vertices[v] for v in face] for face in faces])
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    return float(area * np.mean(radiance))


def build(mi, np, path, sampler="independent"):
    folder = pathlib.Path(path).parent
    scene = tomllib.load(open(path, "rb"))
    camera, film = scene["camera"], scene["film"]
    to_world = mi.ScalarTransform4f().look_at(origin=camera["position"], target=camera["look_at"], up=camera["up"])
    out = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": scene["integrator"]["max_bounces"] + 1, "rr_depth": 5},
        "sensor": {
            "type": "perspective",
            "fov": camera["vfov"],
            "fov_axis": "y",
            "to_world": to_world,
            "film": {"type": "hdrfilm", "width": film["width"], "height": film["height"], "rfilter": {"type": "box"}},
            "sampler": {"type": sampler},
        },
    }
    materials = scene["materials"]
    for m, mesh in enumerate(scene.get("mesh", [])):
        vertices, groups = parse_obj(folder / mesh["file"])
        for name, faces in groups.items():
            material = materials[name]
            props = mi.Properties()
            props["bsdf"] = mi.load_dict(bsdf(material))
            if any(material.get("emission", [0])):
                props["emitter"] = mi.load_dict({
                    "type": "area", "radiance": rgb(material["emission"]),
                    "sampling_weight": power(np, vertices, faces, material["emission"]),
                })
            used = sorted({v for f in faces for v in f})
            remap = {v: i for i, v in enumerate(used)}
            shape = mi.Mesh(f"{m}_{name}", len(used), len(faces), props=props)
            params = mi.traverse(shape)
            params["vertex_positions"] = np.array([vertices[v] for v in used], dtype=np.float32).ravel()
            params["faces"] = np.array([[remap[v] for v in f] for f in faces], dtype=np.uint32).ravel()
            params.update()
            out[f"mesh_{m}_{name}"] = shape
    for i, sphere in enumerate(scene.get("sphere", [])):
        material = materials[sphere["material"]]
        out[f"sphere_{i}"] = {"type": "sphere", "center": sphere["center"], "radius": sphere["radius"], "bsdf": bsdf(material)}
    if "environment" in scene:
        env = scene["environment"]
        if "file" in env:
            out["environment"] = {"type": "envmap", "filename": str(folder / env["file"])}
        else:
            out["environment"] = {"type": "constant", "radiance": rgb(env["radiance"])}
    return mi.load_dict(out), film["width"] * film["height"]


def relmse(np, image, reference):
    """As of ../shared/refs/README.md."""
    return float(np.mean((image - reference) ** 2 / (reference ** 2 + 0.01)))


def errors(mi, dr, np, args):
    """Prints a row a seed and budget, and what the process took that was not rendering."""
    scene, _ = build(mi, np, args.scenes[0], args.sampler)
    reference = np.array(mi.Bitmap(args.reference).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))

    def render(spp, seed):
        start = time.perf_counter()
        image = mi.render(scene, spp=spp, seed=seed)
        dr.eval(image)
        dr.sync_thread()
        return image, time.perf_counter() - start

    budgets = [int(n) for n in args.budgets.split(",")]
    image, _ = render(budgets[0], 0)  # compiles, or finds what an earlier process compiled
    with tempfile.TemporaryDirectory() as folder:
        mi.Bitmap(image).write(f"{folder}/image.exr")
    written = time.perf_counter() - STARTED
    _, rendering = render(budgets[0], 0)
    print(json.dumps({"scene": args.scenes[0], "version": mi.__version__, "sampler": args.sampler,
                      "beside_rendering_seconds": written - rendering}), flush=True)
    for seed in map(int, args.seeds.split(",")):
        for spp in budgets:
            image, seconds = render(spp, 1 + seed)
            print(json.dumps({"seed": seed, "spp": spp, "seconds": seconds,
                              "relmse": relmse(np, np.array(image)[..., :3], reference)}), flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("scenes", nargs="+")
    arguments.add_argument("--variant", default="llvm_ad_rgb")
    arguments.add_argument("--windows", type=int, default=5)
    arguments.add_argument("--spp", type=int, default=64)
    arguments.add_argument("--threads", type=int, default=2)
    arguments.add_argument("--sampler", default="independent", help="or multijitter, its best")
    arguments.add_argument("--reference", help="EXR to measure errors against, of one scene")
    arguments.add_argument("--budgets", default="16,64,256", help="samples a pixel, of errors")
    arguments.add_argument("--seeds", default="0", help="of errors: numbers with commas")
    args = arguments.parse_args()
    if args.reference and len(args.scenes) != 1:
        sys.exit("--reference goes with one scene")
    os.sched_setaffinity(0, range(args.threads))

    import drjit as dr
    import mitsuba as mi
    import numpy as np

    mi.set_variant(args.variant)
    dr.set_thread_count(args.threads)
    if args.reference:
        errors(mi, dr, np, args)
        return
    for path in args.scenes:
        scene, pixels = build(mi, np, path, args.sampler)
        rates = []
        for window in range(args.windows + 1):
            start = time.perf_counter()
            image = mi.render(scene, spp=args.spp, seed=window)
            dr.eval(image)
            dr.sync_thread()
            if window > 0:  # the first compiles
                rates.append(pixels * args.spp / (time.perf_counter() - start) / 1e6)
        print(json.dumps({
            "scene": path, "variant": args.variant, "spp": args.spp, "threads": args.threads,
            "mpaths_per_s": statistics.median(rates), "min": min(rates), "max": max(rates),
            "mean": [float(x) for x in np.array(image).mean(axis=(0, 1))],
        }), flush=True)


if __name__ == "__main__":
    main()
