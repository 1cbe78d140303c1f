#!/usr/bin/env python3
"""Measures the choices of `reference.lights` against each other, and shows them in pt-reference/README.md.

usage: scripts/reference_lights.py [--pt target/release/pt] [--size 64x36] [--spp 64] [--seeds 4] [--truth 2048] [--readme pt-reference/README.md] [SCENE...]

SCENE is a built-in scene or a glTF file [default: lamps room cornell gallery]. Ground truth is `pt reference --spp TRUTH` with another seed, half of it
with the first choice and half with the last one. Each row is the mean relMSE of SEEDS renders at equal samples, and at equal time: relMSE x time,
where time is that of the processor (user and system) for TRUTH / 2 samples beyond what a render of 1 sample takes (the column start), so that other programs on the
machine count little. Both are divided by
those of the first choice. On a GPU, where the processor only waits, give --wall: the time that passes. The table is put between the
markers of the README; with --readme - it is printed alone.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

BEGIN = "<!-- choice of lights: generated, see scripts/reference_lights.py -->"
END = "<!-- end of choice of lights -->"


def run(command, wall):
    """Runs it and returns its seconds."""
    before, start = os.times(), time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"reference_lights: {' '.join(command)}: {(done.stderr.strip() or str(done.returncode)).splitlines()[-1]}")
    after = os.times()
    processor = after.children_user + after.children_system - before.children_user - before.children_system
    return time.monotonic() - start if wall else processor


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["lamps", "room", "cornell", "gallery"])
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--size", default="64x36")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--truth", type=int, default=2048)
    parser.add_argument("--wall", action="store_true")
    parser.add_argument("--readme", default="pt-reference/README.md")
    args = parser.parse_args()
    knobs = json.loads(subprocess.run([args.pt, "knobs", "reference", "--json"], capture_output=True, text=True, check=True).stdout)
    choices = next(knob["values"] for knob in knobs if knob["key"] == "reference.lights")
    lines = [
        "| scene | lights | relMSE | at equal samples | at equal time | start, s |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def render(scene, choice, spp, seed, path):
            command = [args.pt, "reference", scene, "--size", args.size, "--spp", str(spp), "--seed", str(seed), "--no-aov"]
            return run(command + ["--set", f"reference.lights={choice}", "-o", str(path)], args.wall)

        def error(path, truth):
            command = [args.pt, "compare", str(path), str(truth), "--metric", "relmse", "--json"]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            return json.loads(done.stdout)["metrics"]["relmse"]["value"]

        for scene in args.scenes:
            starts, seconds = {}, {}
            for choice in choices:
                starts[choice] = render(scene, choice, 1, 0, folder / "start.exr")
                seconds[choice] = render(scene, choice, args.truth // 2, 1000, folder / f"{choice}.exr") - starts[choice]
            truths = [folder / f"{choice}.exr" for choice in (choices[0], choices[-1])]
            first = None
            for choice in choices:
                errors = []
                for seed in range(1, args.seeds + 1):
                    path = folder / "render.exr"
                    render(scene, choice, args.spp, seed, path)
                    # The renders of the truths are independent, so the mean of both errors is that to their mean, but for a constant.
                    errors.append(sum(error(path, truth) for truth in truths) / 2)
                relmse, spent, start = sum(errors) / args.seeds, seconds[choice], starts[choice]
                first = first or (relmse, spent)
                lines.append(
                    f"| {pathlib.Path(scene).stem} | {choice} | {relmse:.5f} | {relmse / first[0]:.2f}"
                    f" | {relmse * spent / (first[0] * first[1]):.2f} | {start:.1f} |"
                )
                print(lines[-1], file=sys.stderr, flush=True)
    device = next((line for line in subprocess.run([args.pt, "info"], capture_output=True, text=True).stdout.splitlines() if line.strip()), "")
    head = f"`scripts/reference_lights.py --size {args.size} --spp {args.spp} --seeds {args.seeds} --truth {args.truth}`; {device.strip()}."
    table = "\n".join([head, "", *lines])
    if args.readme == "-":
        print(table)
        return
    path = pathlib.Path(args.readme)
    text = path.read_text()
    if BEGIN not in text or END not in text:
        sys.exit(f"reference_lights: {path} has no line {BEGIN!r} and {END!r}")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    path.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}")


if __name__ == "__main__":
    main()
