#!/usr/bin/env python3
"""Measures paths a second of Mitsuba 3 and of `pt` in the built-in scene `room`, in turns on the same processor, and compares their means.

usage: pip install mitsuba numpy
       scripts/mitsuba_room.py [--pt target/release/pt] [--variant llvm_ad_rgb] [--size 320x180] [--spp 64] [--bounces 8] [--roulette 3]
                               [--turns 5] [--set reference.lights=per-kind]

The scene is made here as pt-scene/src/builtin/room.rs makes it, and both integrators have the same depth (max_depth = bounces + 2) and begin
Russian roulette at the same event (rr_depth = roulette + 1). Each turn is `pt bench path room` with the device of --device and one render of
Mitsuba with another seed; the first render, which compiles, is not counted. Variants llvm_* need LLVM, see DRJIT_LIBLLVM_PATH of Dr.Jit.
The last line compares the means of the image with those of `pt reference`, relative, each channel.
"""

import argparse
import json
import math
import os
import pathlib
import statistics
import subprocess
import tempfile
import time

import numpy as np

COLORS = {
    "wall": (0.75, 0.74, 0.72),
    "floor": (0.45, 0.40, 0.36),
    "stone": (0.70, 0.68, 0.62),
    "red": (0.62, 0.16, 0.12),
    "green": (0.20, 0.50, 0.22),
    "blue": (0.16, 0.28, 0.60),
    "lamp": (0.0, 0.0, 0.0),
}
HALF, HEIGHT, LAMP = (6.0, 4.5), 4.0, 12.0
X, Y, Z = np.eye(3)


class Mesh:
    """Triangles of one material."""

    def __init__(self):
        self.positions, self.normals, self.indices = [], [], []

    def add(self, positions, normals, indices):
        first = sum(len(p) for p in self.positions)
        self.positions.append(positions)
        self.normals.append(normals)
        self.indices.append(indices + first)

    def quad(self, corner, u, v):
        corner, normal = np.asarray(corner, float), np.cross(u, v)
        positions = np.array([corner, corner + u, corner + u + v, corner + v])
        normals = np.tile(normal / np.linalg.norm(normal), (4, 1))
        self.add(positions, normals, np.array([[0, 1, 2], [0, 2, 3]]))

    def cuboid(self, least, most):
        x, y, z = np.diag(most - least)
        for corner, u, v in (
            (least + z, x, y), (most - y, -z, y), (least + x, -x, y), (least, z, y), (least + z + y, x, -z), (least, x, z)
        ):
            self.quad(corner, u, v)

    def surface(self, cells, point, inside_out=False):
        """`point` maps arrays u, v in 0..1 to positions; normals are dP/du x dP/dv."""
        (nu, nv), step = cells, 2e-4
        v, u = (grid.ravel() for grid in np.meshgrid(np.arange(nv + 1) / nv, np.arange(nu + 1) / nu, indexing="ij"))

        def normals_at(v):
            return np.cross(point(u + step, v) - point(u - step, v), point(u, v + step) - point(u, v - step))

        normals = normals_at(v)
        at_poles = normals_at(v + np.where(v < 0.5, 4 * step, -4 * step))
        normals = np.where(np.linalg.norm(normals, axis=1, keepdims=True) > 1e-9, normals, at_poles)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        row = nu + 1
        a = (np.arange(nv)[:, None] * row + np.arange(nu)[None, :]).ravel()
        indices = np.stack([a, a + 1, a + row + 1, a, a + row + 1, a + row], axis=1).reshape(-1, 3)
        if inside_out:
            normals, indices = -normals, indices[:, [0, 2, 1]]
        self.add(point(u, v), normals, indices)

    def lathe(self, foot, cells, profile, flute):
        def point(u, v):
            radius, y = profile(v)
            angle = 2 * np.pi * u
            radius = radius * flute(angle)
            return np.asarray(foot) + np.stack([radius * np.cos(angle), y, -radius * np.sin(angle)], axis=1)

        self.surface(cells, point)

    def sphere(self, center, radius, n):
        def point(u, v):
            a, p = 2 * np.pi * u, np.pi * v
            return np.asarray(center) + radius * np.stack([np.sin(p) * np.cos(a), np.cos(p), -np.sin(p) * np.sin(a)], axis=1)

        self.surface((2 * n, n), point, inside_out=True)


def room():
    """Meshes by material, as pt-scene/src/builtin/room.rs makes them."""
    meshes = {name: Mesh() for name in COLORS}
    (x, z), up = HALF, Y * HEIGHT
    corner, across, deep = np.array([-x, 0, -z]), X * 2 * x, Z * 2 * z
    for material, at, u, v in (
        ("floor", corner, deep, across),
        ("wall", corner + up, across, deep),
        ("wall", corner, across, up),
        ("wall", corner + deep, up, across),
        ("wall", corner, up, deep),
        ("wall", corner + across, deep, up),
    ):
        meshes[material].quad(at, u, v)
    for k in range(3):
        meshes["lamp"].quad([-4 + 3 * k, HEIGHT - 0.01, -1], X * 2, Z * 2)
    for k in range(8):
        meshes["stone"].lathe(
            [-4.5 + 3 * (k % 4), 0, -2.8 if k < 4 else 2.8],
            (96, 72),
            lambda v: (0.28 - 0.05 * v + 0.06 * np.exp(40 * (v - 0.97)), HEIGHT * v),
            lambda angle: 1 - 0.06 * np.abs(np.cos(12 * angle)),
        )
    for k in range(6):
        column, row = k % 3, k // 3
        at = np.array([-3.2 + 3.1 * column, 0, -0.9 if row == 0 else 1.0])
        half = np.array([0.35, 0.4 + 0.1 * column, 0.35])
        top = at + Y * 2 * half[1]
        flat = half * [1, 0, 1]
        meshes["stone"].cuboid(at + Y * 1e-3 - flat, top + flat)
        meshes[("red", "green", "blue")[k % 3]].sphere(top + Y * 0.5, 0.49, 72)
    return meshes


def mitsuba_scene(mi, args, size):
    description = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": args.bounces + 2, "rr_depth": args.roulette + 1},
        "sensor": {
            "type": "perspective",
            "fov": math.degrees(1.05),
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(origin=[5.4, 1.9, 4.1], target=[-1.5, 1.3, -0.8], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": args.spp},
        },
    }
    triangles = 0
    for name, made in room().items():
        positions, normals, indices = map(np.concatenate, (made.positions, made.normals, made.indices))
        triangles += len(indices)
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": COLORS[name]}})
        if name == "lamp":
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": [LAMP] * 3}})
        mesh = mi.Mesh(name, len(positions), len(indices), has_vertex_normals=True, props=properties)
        values = mi.traverse(mesh)
        values["vertex_positions"] = positions.astype(np.float32).ravel()
        values["vertex_normals"] = normals.astype(np.float32).ravel()
        values["faces"] = indices.astype(np.uint32).ravel()
        values.update()
        description[name] = mesh
    return mi.load_dict(description), triangles


def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"mitsuba_room: {' '.join(command)}: {done.stderr.strip()}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--bounces", type=int, default=8)
    parser.add_argument("--roulette", type=int, default=3)
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--set", action="append", default=[])
    args = parser.parse_args()
    size = [int(side) for side in args.size.split("x")]

    import mitsuba as mi

    mi.set_variant(args.variant)
    scene, triangles = mitsuba_scene(mi, args, size)
    print(f"room: {triangles} triangles, {args.size}, {args.spp} samples a pixel, {args.bounces} bounces, roulette after {args.roulette};", end=" ")
    print(f"Mitsuba {mi.__version__} {args.variant}, {os.cpu_count()} logical processors", flush=True)
    np.array(mi.render(scene, spp=args.spp, seed=0))
    paths = size[0] * size[1] * args.spp * 1e-6
    settings = [word for setting in args.set for word in ("--set", setting)]
    rates, image = [], 0.0
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "path.json"
        for turn in range(args.turns):
            start = time.perf_counter()
            image = image + np.array(mi.render(scene, spp=args.spp, seed=turn + 1)) / args.turns
            theirs = paths / (time.perf_counter() - start)
            command = [args.pt, "bench", "path", "room", "--size", args.size, "--spp", "8", "--windows", "3", "--device", args.device]
            run([*command, "--max-bounces", str(args.bounces), "--roulette-start", str(args.roulette), *settings, "--json", str(out)])
            ours = json.loads(out.read_text())["mpaths_per_s"]
            rates.append((theirs, ours))
            print(f"turn {turn + 1}: Mitsuba {theirs:.3f}, pt {ours:.3f} Mpaths/s: {ours / theirs:.3f} x", flush=True)
        ratios = sorted(ours / theirs for theirs, ours in rates)
        theirs, ours = (statistics.median(column) for column in zip(*rates))
        print(f"median: Mitsuba {theirs:.3f}, pt {ours:.3f} Mpaths/s; {statistics.median(ratios):.3f} x ({ratios[0]:.3f} to {ratios[-1]:.3f})")
        picture = pathlib.Path(folder) / "reference.exr"
        depth = ["--set", f"reference.max_bounces={args.bounces}", "--set", f"reference.roulette_start={args.roulette}"]
        spp = str(args.spp * args.turns)
        run([args.pt, "reference", "room", "--size", args.size, "--spp", spp, "--no-aov", "--device", args.device, *depth, *settings, "-o", str(picture)])
        mi.set_variant("scalar_rgb")
        ours = np.array(dict(mi.Bitmap(str(picture)).split())["<root>"])
        ratio = ours.mean(axis=(0, 1)) / image.mean(axis=(0, 1))
        print("mean of pt / mean of Mitsuba:", " ".join(f"{channel:.4f}" for channel in ratio))


if __name__ == "__main__":
    main()
