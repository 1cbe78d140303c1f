#!/usr/bin/env python3
"""Measures the direct lighting pass with each light sampler, and shows the times in pt-lights/README.md. Run it on a GPU.

usage: scripts/direct_pass.py [--pt target/release/pt] [--size 1920x1080] [--readme pt-lights/README.md] [SCENE...]

SCENE is a built-in scene or a glTF file [default: lamps gallery]. The table is put between the markers of the README; with --readme - it is
printed alone. Each row is `pt bench stage lights --scene SCENE --size SIZE --set lights.sampler=SAMPLER`, the last with `lights.rays=per-kind`: the
median times of all passes of the stage and of those that trace rays, and the rays of a frame. "Of the rate" is rays / time over the rate of shadow
rays of the same scene that `pt bench` measures, once for the passes that trace and once for the whole stage.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

BEGIN = "<!-- direct pass by sampler: generated, see scripts/direct_pass.py -->"
END = "<!-- end of direct pass by sampler -->"


def bench(args, scene, setting, folder, times_only):
    path = folder / "bench.json"
    command = [args.pt, "bench", "stage", "lights", "--scene", scene, "--size", args.size, "--set", setting]
    command += ["--json", str(path)] + (["--times-only"] if times_only else [])
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"direct_pass: {' '.join(command)}: {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else done.returncode}")
    return json.loads(path.read_text())


def row(scene, sampler, part, rate):
    tracing = [p for p in part["passes"] if p["rays"] and p["rays"]["count"]]
    rays = sum(p["rays"]["count"] for p in tracing)
    at_most = "at most " if any(p["rays"]["is_upper_bound"] for p in tracing) else ""
    whole, traced = part["time"]["median_ms"], sum(p["median_ms"] for p in tracing)
    share = lambda ms: f"{at_most}{rays / ms * 1e-1 / rate:.0f} %" if ms > 0 and rays else "-"
    name = pathlib.Path(scene).stem
    return (
        f"| {name} | {sampler} | {whole:.3f} | {traced:.3f} | {at_most}{rays / 1e6:.2f} M | {share(traced)} | {share(whole)} |"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["lamps", "gallery"])
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--readme", default="pt-lights/README.md")
    args = parser.parse_args()
    knobs = json.loads(subprocess.run([args.pt, "knobs", "lights", "--json"], capture_output=True, text=True, check=True).stdout)
    samplers = next(knob["values"] for knob in knobs if knob["key"] == "lights.sampler")
    settings = {sampler: f"lights.sampler={sampler}" for sampler in samplers} | {"per-kind": "lights.rays=per-kind"}
    lines = [
        "| scene | sampler | stage, ms | passes that trace, ms | rays a frame | of the rate, tracing | of the rate, stage |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    captions = []
    with tempfile.TemporaryDirectory() as folder:
        for scene in args.scenes:
            rate = None
            for sampler, setting in settings.items():
                found = bench(args, scene, setting, pathlib.Path(folder), rate is not None)
                part = next(part for part in found["parts"] if part["name"] == "lights")
                if rate is None:
                    rate = dict(found["yardsticks"]["mrays_per_s"])["shadow"]
                    captions.append(f"{pathlib.Path(scene).stem} {rate:.0f} million shadow rays a second ({found['backend']})")
                lines.append(row(scene, sampler, part, rate))
                print(lines[-1], file=sys.stderr, flush=True)
    device = f"{found['device']}, driver {found['driver']}"
    head = f"`scripts/direct_pass.py --size {args.size}`; {device}. Measured rates: {', '.join(captions)}."
    table = "\n".join([head, "", *lines])
    if args.readme == "-":
        print(table)
        return
    path = pathlib.Path(args.readme)
    text = path.read_text()
    if BEGIN not in text or END not in text:
        sys.exit(f"direct_pass: {path} has no line {BEGIN!r}")
    before, rest = text.split(BEGIN, 1)
    path.write_text(f"{before}{BEGIN}\n{table}\n{END}{rest.split(END, 1)[1]}")


if __name__ == "__main__":
    main()
