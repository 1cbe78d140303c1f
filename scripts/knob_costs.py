#!/usr/bin/env python3
"""Measures what two values of a knob cost in time and bytes of a whole frame, with the two in turns. Run it on a GPU.

usage: scripts/knob_costs.py [--pt target/release/pt] [--size 1920x1080] [--turns 5] [--page docs/src/generated/knob_costs.md]
                             [--sponza Sponza.gltf] [SCENE KNOB A B]

Without SCENE, KNOB, A and B: the alternatives of materials, textures and geometry that `pt` has, see PAIRS, in built-in scenes and, with --sponza,
in that file. KNOB may be `backend`: then A and B are backends. Each turn is `pt bench frame --scene SCENE --size SIZE --set KNOB=VALUE --times-only
--frames 16 --rounds 3 --json F` with A and with B. The change is the mean over the turns of the logarithm of the ratio of their median frame times, its 95 %
interval that of Student's t. Bytes are what all passes of a frame read and write, per pixel, at most. With --page - the table is printed alone.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

# Scene (None: the file of --sponza), knob, value before and after.
PAIRS = [
    ("gallery", "gbuffer.format", "full", "compact"),
    (None, "gbuffer.format", "full", "compact"),
    ("gallery", "gbuffer.texture_filter", "hardware", "stochastic"),
    ("textures", "gbuffer.texture_filter", "hardware", "stochastic"),
    ("gallery", "gbuffer.opacity_table", "false", "true"),
    (None, "gbuffer.opacity_table", "false", "true"),
    ("gallery", "gbuffer.decomposition", "replacement", "planes"),
    ("glass", "gbuffer.decomposition", "replacement", "planes"),
    ("gallery", "backend", "rt-pipeline", "rt-reorder"),
]
# 97.5 % quantile of Student's t for this many turns.
STUDENT = {3: 4.303, 4: 3.182, 5: 2.776, 6: 2.571, 7: 2.447, 8: 2.365, 9: 2.306, 10: 2.262}


def bench(args, scene, knob, value, path):
    setting = ["--backend", value] if knob == "backend" else ["--set", f"{knob}={value}"]
    command = [args.pt, "bench", "frame", "--scene", scene, "--size", args.size, *setting]
    command += ["--times-only", "--frames", "16", "--rounds", "3", "--json", str(path)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"exit code {done.returncode}")
    return json.loads(path.read_text())


def change(before, after):
    """Mean of after / before - 1 and the ends of its 95 % interval."""
    logs = [math.log(b / a) for a, b in zip(before, after)]
    mean, half = statistics.mean(logs), STUDENT[len(logs)] * statistics.stdev(logs) / math.sqrt(len(logs))
    return [math.expm1(x) for x in (mean, mean - half, mean + half)]


def bytes_a_pixel(run):
    return sum(p["bytes"] or 0 for p in run["parts"][0]["passes"]) / math.prod(run["size"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pair", nargs="*", metavar="SCENE KNOB A B")
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--sponza")
    parser.add_argument("--page", default="docs/src/generated/knob_costs.md")
    args = parser.parse_args()
    if len(args.pair) not in (0, 4) or args.turns not in STUDENT:
        sys.exit("knob_costs: SCENE, KNOB, A and B belong together, and --turns is 3 to 10")
    pairs = [tuple(args.pair)] if args.pair else [(s or args.sponza, *rest) for s, *rest in PAIRS if s or args.sponza]
    print_row = lambda cells: f"| {' | '.join(cells)} |"
    lines = [print_row(["scene", "knob", "values", "ms", "change", "95 % interval", "bytes a pixel"]), "|" + " --- |" * 7]
    device = ""
    for scene, knob, a, b in pairs:
        name = pathlib.Path(scene).stem
        try:
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder, "bench.json")
                turns = [[bench(args, scene, knob, value, path) for value in (a, b)] for _ in range(args.turns)]
        except RuntimeError as error:
            lines.append(print_row([name, f"`{knob}`", f"{a}, {b}", f"not measured: {error}", "", "", ""]))
            print(lines[-1], file=sys.stderr)
            continue
        device = f"{turns[0][0]['device']}, {turns[0][0]['driver']}"
        before, after = ([turn[i]["parts"][0]["time"]["median_ms"] for turn in turns] for i in (0, 1))
        mean, low, high = change(before, after)
        lines.append(print_row([
            name, f"`{knob}`", f"{a}, {b}", f"{statistics.median(before):.3f}, {statistics.median(after):.3f}", f"{mean:+.2%}",
            f"{low:+.2%} to {high:+.2%}", "{:.0f}, {:.0f}".format(*map(bytes_a_pixel, turns[0])),
        ]))
        print(lines[-1], file=sys.stderr)
    page = f"`scripts/knob_costs.py`, frames of {args.size}, {args.turns} turns, {device}.\n\n" + "\n".join(lines) + "\n"
    if args.page == "-":
        print(page, end="")
    else:
        pathlib.Path(args.page).write_text(page)


if __name__ == "__main__":
    main()
