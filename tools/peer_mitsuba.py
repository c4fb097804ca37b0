#!/usr/bin/env python3
"""Camera paths per second of Mitsuba 3 (llvm, independent sampler) on a scene.toml of ours, for comparison.

    pip install mitsuba numpy          # and an LLVM, on Debian: apt-get install libllvm19
    python3 tools/peer_mitsuba.py SCENE.toml [...] [--variant llvm_ad_rgb] [--windows 5] [--spp 64] [--threads 2]

Reads what the reference scenes use: OBJ meshes by usemtl, spheres, diffuse, conductor, dielectric, area emission,
environment, pinhole camera. Prints JSON: median, minimum and maximum over the windows, each a whole render of the
already loaded and compiled scene.
"""
import argparse
import json
import os
import pathlib
import statistics
import time
import tomllib


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


def build(mi, np, path):
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
            "sampler": {"type": "independent"},
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
                props["emitter"] = mi.load_dict({"type": "area", "radiance": rgb(material["emission"])})
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


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("scenes", nargs="+")
    arguments.add_argument("--variant", default="llvm_ad_rgb")
    arguments.add_argument("--windows", type=int, default=5)
    arguments.add_argument("--spp", type=int, default=64)
    arguments.add_argument("--threads", type=int, default=2)
    args = arguments.parse_args()
    os.sched_setaffinity(0, range(args.threads))

    import drjit as dr
    import mitsuba as mi
    import numpy as np

    mi.set_variant(args.variant)
    dr.set_thread_count(args.threads)
    for path in args.scenes:
        scene, pixels = build(mi, np, path)
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
