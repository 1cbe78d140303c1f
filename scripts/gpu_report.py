#!/usr/bin/env python3
"""The frame and the trace backends on one device: checks the results, then prints tables in Markdown.

usage: scripts/gpu_report.py PT [--size 1920x1080] [--frames 64] [--device D] [--env F] [SCENE...]

PT is the program (target/release/pt). Scenes default to the built-in gallery. Exit code 1 when a check fails: the images of
two backends differ by more than relMSE 1e-3, or a frame after the second created a pipeline or took device memory.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

BACKENDS = ["compute", "ray-query", "rt-pipeline", "rt-reorder"]


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nexit {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pt", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", default=["gallery"])
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--frames", default="64")
    parser.add_argument("--device", default="0")
    parser.add_argument("--env")
    args = parser.parse_args()

    info = json.loads(run(args.pt, "info", "--json", "--device", args.device))["devices"][0]
    missing = {backend for backend, _ in info["auto"]["missing"]}
    backends = [backend for backend in BACKENDS if backend not in missing]
    device = info["device"]
    print(f"{device['name']}, {device['driver']} {device['driver_version']}, Vulkan {device['vulkan']}")
    print(f"auto on the gallery: {info['auto']['backend']} {info['auto']['mrays_per_s']}")
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for scene in args.scenes:
            failed += report(args, backends, scene, folder)
    for failure in failed:
        print(f"FAILED: {failure}")
    return 1 if failed else 0


def report(args, backends, scene, folder):
    failed = []
    name = pathlib.Path(scene).stem
    rows = json_of(folder / "bench.json", lambda f: run(args.pt, "bench", "trace", scene, "--size", args.size,
                                                        "--device", args.device, "--json", f))["rows"]
    print(f"\n## {name}: rays, {args.size} of each kind, Mrays/s (share that agrees with the CPU's traversal)\n")
    kinds = ("primary", "bounce", "shadow", "bounce-shadow")
    print(f"| backend | {' | '.join(kinds)} |\n|---{'|---' * len(kinds)}|")
    for backend in [*backends, "native"]:
        of = {row["kind"]: row for row in rows if row["backend"] == backend}
        # Where nothing is hit there are no further rays.
        cells = [f"{of[k]['mrays_per_s']:.1f} ({of[k]['agreement']:.5f})" if k in of else "-" for k in kinds]
        print(f"| {backend} | {' | '.join(cells)} |")

    timings = {}
    for backend in backends:
        env = ["--env", args.env] if args.env else []
        timings[backend] = json_of(folder / f"{backend}.json", lambda f: print(run(
            args.pt, "render", scene, *env, "--size", args.size, "--frames", args.frames, "--device", args.device,
            "--backend", backend, "--timings", f, "-o", folder / f"{name}-{backend}.exr").strip()))
        for frame in timings[backend]["frames"][2:]:
            if any(frame["created"].values()):
                failed.append(f"{name}, {backend}: frame {frame['frame']} created {frame['created']}")
    print(f"\n## {name}: the frame at {args.size}, GPU ms, median (95th percentile) of {args.frames} frames\n")
    print(f"| pass | {' | '.join(backends)} |\n|---{'|---' * len(backends)}|")
    for i, row in enumerate(timings[backends[0]]["passes"]):
        cells = [f"{t['passes'][i]['median_ms']:.3f} ({t['passes'][i]['p95_ms']:.3f})" for t in timings.values()]
        print(f"| {row['pass']} | {' | '.join(cells)} |")
    cells = [f"{t['frame']['median_ms']:.3f} ({t['frame']['p95_ms']:.3f})" for t in timings.values()]
    print(f"| whole frame | {' | '.join(cells)} |")
    first = folder / f"{name}-{backends[0]}.exr"
    for backend in backends[1:]:
        other = folder / f"{name}-{backend}.exr"
        measured = json.loads(run(args.pt, "compare", other, first, "--metric", "relmse", "--json"))
        relmse = measured["metrics"]["relmse"]["value"]
        print(f"\n{backend} against {backends[0]}: relMSE {relmse:.3e}")
        if relmse > 1e-3:
            failed.append(f"{name}: {backend} differs from {backends[0]} by relMSE {relmse:.3e}")
    return failed


def json_of(path, fill):
    fill(path)
    return json.loads(path.read_text())


if __name__ == "__main__":
    sys.exit(main())
