#!/usr/bin/env python3
"""Balls of metal and of glass over roughness: frames (above) and the reference (below), for pt-gbuffer/README.md.

usage: scripts/roughness_picture.py [--pt target/release/pt] [--size 880x200] [--frames 256] [--spp 256] [-o docs/roughness.png]

Writes the scene as glTF into a temporary folder: eleven balls of metal, in front of them eleven of glass, of the roughness that ROUGHNESS lists, on a
striped floor under the default sky, with a point light. Mirrors and smooth glass are replaced by what they show, rough metals are shaded with bounce
rays: the picture goes on from ball to ball without a step.
"""

import argparse
import base64
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

ROUGHNESS = [0.0, 0.01, 0.019, 0.021, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5]
RADIUS, STEP = 0.4, 0.9
AROUND, DOWN = 48, 24


class Gltf:
    """Meshes of positions, normals and indices in one buffer."""

    def __init__(self):
        self.bytes = b""
        self.json = {"asset": {"version": "2.0"}, "extensionsUsed": [], "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
                     "meshes": [], "materials": [], "accessors": [], "bufferViews": []}

    def node(self, **node):
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]))
        self.json["nodes"].append(node)

    def extension(self, name, value):
        self.json["extensionsUsed"] = sorted({*self.json["extensionsUsed"], name})
        return {name: value}

    def accessor(self, values, kind, component, code):
        flat = [number for value in values for number in (value if isinstance(value, tuple) else (value,))]
        data = struct.pack(f"<{len(flat)}{code}", *flat)
        accessor = {"bufferView": len(self.json["bufferViews"]), "componentType": component, "count": len(values), "type": kind}
        if kind == "VEC3":
            accessor["min"] = [min(value[axis] for value in values) for axis in range(3)]
            accessor["max"] = [max(value[axis] for value in values) for axis in range(3)]
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.json["accessors"].append(accessor)
        self.bytes += data
        return len(self.json["accessors"]) - 1

    def geometry(self, positions, normals, indices):
        attributes = {"POSITION": self.accessor(positions, "VEC3", 5126, "f"), "NORMAL": self.accessor(normals, "VEC3", 5126, "f")}
        return {"attributes": attributes, "indices": self.accessor(indices, "SCALAR", 5125, "I")}

    def place(self, geometry, material, at=(0.0, 0.0, 0.0)):
        self.json["materials"].append(material)
        self.json["meshes"].append({"primitives": [{**geometry, "material": len(self.json["materials"]) - 1}]})
        self.node(mesh=len(self.json["meshes"]) - 1, translation=list(at))

    def write(self, path):
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.bytes).decode()
        path.write_text(json.dumps({**self.json, "buffers": [{"byteLength": len(self.bytes), "uri": uri}]}))


def ball():
    normals, indices = [], []
    for j in range(DOWN + 1):
        for i in range(AROUND + 1):
            polar, azimuth = math.pi * j / DOWN, 2.0 * math.pi * i / AROUND
            normals.append((math.sin(polar) * math.cos(azimuth), math.cos(polar), -math.sin(polar) * math.sin(azimuth)))
            if i < AROUND and j < DOWN:
                a, b = j * (AROUND + 1) + i, (j + 1) * (AROUND + 1) + i
                indices += [a, b, b + 1, a, b + 1, a + 1]
    return [tuple(RADIUS * axis for axis in normal) for normal in normals], normals, indices


def scene(path):
    gltf = Gltf()
    geometry = gltf.geometry(*ball())
    across = 0.5 * STEP * (len(ROUGHNESS) - 1)
    for i, roughness in enumerate(ROUGHNESS):
        metal = {"pbrMetallicRoughness": {"baseColorFactor": [0.95, 0.8, 0.5, 1.0], "metallicFactor": 1.0, "roughnessFactor": roughness}}
        gltf.place(geometry, metal, (STEP * i - across, RADIUS + 0.8, -1.0))
        glass = {"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": roughness},
                 "extensions": {**gltf.extension("KHR_materials_transmission", {"transmissionFactor": 1.0}),
                                **gltf.extension("KHR_materials_volume", {"thicknessFactor": 1.0}),
                                **gltf.extension("KHR_materials_ior", {"ior": 1.5})}}
        gltf.place(geometry, glass, (STEP * i - across, RADIUS, 0.3))
    for stripe in range(24):
        z = 2.0 - 0.4 * stripe
        corners = [(-12.0, 0.0, z), (12.0, 0.0, z), (12.0, 0.0, z - 0.4), (-12.0, 0.0, z - 0.4)]
        grey = 0.7 if stripe % 2 else 0.15
        floor = {"pbrMetallicRoughness": {"baseColorFactor": [grey, grey, grey, 1.0], "metallicFactor": 0.0},
                 "extensions": gltf.extension("KHR_materials_specular", {"specularFactor": 0.0})}
        gltf.place(gltf.geometry(corners, [(0.0, 1.0, 0.0)] * 4, [0, 1, 2, 0, 2, 3]), floor)
    light = {"type": "point", "intensity": 300.0, "color": [1.0, 0.9, 0.8]}
    gltf.json["extensions"] = gltf.extension("KHR_lights_punctual", {"lights": [light]})
    gltf.node(translation=[2.0, 5.0, 4.0], extensions={"KHR_lights_punctual": {"light": 0}})
    tilt = math.radians(-14.0)
    gltf.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.2, "znear": 0.1}}]
    gltf.node(camera=0, translation=[0.0, 3.9, 11.8], rotation=[math.sin(tilt / 2.0), 0.0, 0.0, math.cos(tilt / 2.0)])
    gltf.write(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--size", default="880x200")
    parser.add_argument("--frames", default="256")
    parser.add_argument("--spp", default="256")
    parser.add_argument("-o", "--output", default="docs/roughness.png")
    args = parser.parse_args()

    def run(*command):
        done = subprocess.run([args.pt, *(str(part) for part in command)], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"roughness_picture: {' '.join(map(str, command))}\nexit {done.returncode}: {done.stderr.strip()}")
        return done.stdout

    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        scene(folder / "roughness.gltf")
        view = [folder / "roughness.gltf", "--size", args.size]
        run("render", *view, "--frames", args.frames, "--accumulate", "--profile", "unbiased", "--set", "indirect.bounces=4", "--set",
            "gbuffer.reflect_refract=6", "-o", folder / "frames.exr")
        run("reference", *view, "--spp", args.spp, "--no-aov", "-o", folder / "reference.exr")
        run("sheet", folder / "frames.exr", folder / "reference.exr", "-o", args.output, "--tile", args.size, "--columns", "1")
        print(run("compare", folder / "frames.exr", folder / "reference.exr", "--metric", "flip,energy"))


if __name__ == "__main__":
    main()
