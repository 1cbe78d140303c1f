#!/usr/bin/env python3
"""What each stabiliser of the profile q2rtx costs in energy, scene by scene, against the reference with paths of the same length.

usage: scripts/energy_table.py [--pt target/release/pt] [--size 64x36] [--frames 256] [--seeds 3] [--spp 1024] [--jobs 1]
                               [--bounces 1] [--profiles-only] [--readme pt-indirect/README.md] [SCENE...]

SCENE is a built-in scene or a glTF file [default: cornell lamps veach gallery]. The table is put between the markers of the README; with
--readme - it is printed alone. A stabiliser is one knob that the profile q2rtx sets and that changes the energy of a frame. "Alone": the
profile unbiased with this knob, over unbiased. "Without": q2rtx with the value that unbiased has for this knob, over q2rtx. Renders that are
compared have the same seeds, so that their noise is the same. --profiles-only leaves the stabilisers out: the table says then how much of
the reference's energy the profiles have.
"""

import argparse
import concurrent.futures
import json
import math
import pathlib
import subprocess
import sys
import tempfile

BEGIN = "<!-- energy of q2rtx: generated, see scripts/energy_table.py -->"
END = "<!-- end of energy of q2rtx -->"
# Knob, its value in the profile q2rtx, its value in the profile unbiased. What q2rtx draws in another way with the same mean is not listed.
STABILISERS = [
    ("lights.partial_metal", "mixed-parameters", "two-brdfs"),
    ("indirect.texture_spread", "0.25", "0"),
    ("indirect.emission_share", "crossover", "mis"),
    ("indirect.ndf_trim", "0.9", "1"),
    ("indirect.specular_fade", "0.2", "1"),
    ("indirect.anti_flicker", "0.8", "0"),
    ("indirect.sun_range", "50", "0"),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["cornell", "lamps", "veach", "gallery"])
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--size", default="64x36")
    parser.add_argument("--frames", default="256")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--spp", default="1024")
    parser.add_argument("--bounces", default="1", help="bounces of the frames and of the reference")
    parser.add_argument("--profiles-only", action="store_true", help="measure no stabilisers")
    parser.add_argument("--jobs", type=int, default=1, help="scenes that are measured at the same time; on a GPU, where the host waits")
    parser.add_argument("--readme", default="pt-indirect/README.md")
    args = parser.parse_args()
    if args.seeds < 2:
        sys.exit("energy_table: --seeds: a standard error needs at least 2")
    if args.readme != "-":
        lines = pathlib.Path(args.readme).read_text().splitlines()
        for marker in (BEGIN, END):
            if marker not in lines:
                sys.exit(f"energy_table: {args.readme} has no line \"{marker}\"")
    with tempfile.TemporaryDirectory() as folder:
        folders = [pathlib.Path(folder, str(index)) for index in range(len(args.scenes))]
        with concurrent.futures.ThreadPoolExecutor(args.jobs) as jobs:
            measured = jobs.map(measure, [args] * len(folders), args.scenes, folders)
            columns = dict(zip(args.scenes, measured))
    table = [*heading(args), *rows(args, columns)]
    print("\n".join(table))
    if args.readme == "-":
        return
    first, last = lines.index(BEGIN), lines.index(END)
    text = [*lines[: first + 1], *table, *lines[last:]]
    pathlib.Path(args.readme).write_text("\n".join(text) + "\n")


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"energy_table: {' '.join(map(str, command))}\nexit {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def measure(args, scene, folder):
    """Pairs (ratio, standard error) by the name of the row."""
    folder.mkdir()
    reference = folder / "reference.exr"
    run(args.pt, "reference", scene, "--size", args.size, "--spp", args.spp, "--max-bounces", args.bounces, "--no-aov", "-o", reference)

    def means(profile, *sets):
        """Energy over that of the reference, seed by seed."""
        knobs = [part for key, value in sets for part in ("--set", f"{key}={value}")]
        found = []
        for seed in range(1, args.seeds + 1):
            image = folder / "image.exr"
            run(args.pt, "render", scene, "--size", args.size, "--frames", args.frames, "--seed", seed, "--accumulate",
                "--profile", profile, "--set", f"indirect.bounces={args.bounces}", "--set", "gbuffer.jitter=pixel",
                "--set", "gbuffer.alternate_fields=true", "--set", "checkerboard.blend_split=false", *knobs, "-o", image)
            measured = json.loads(run(args.pt, "compare", image, reference, "--metric", "energy", "--json"))
            found.append(measured["metrics"]["energy"]["value"])
        return found

    unbiased, q2rtx = means("unbiased"), means("q2rtx")
    column = {"unbiased": summary(unbiased), "q2rtx": summary(q2rtx)}
    for key, value, neutral in stabilisers(args):
        alone = means("unbiased", (key, value))
        without = means("q2rtx", (key, neutral))
        column[key] = (summary(ratios(alone, unbiased)), summary(ratios(without, q2rtx)))
    for name, found in column.items():
        print(f"{scene}, {name}: {found}", file=sys.stderr, flush=True)
    return column


def stabilisers(args):
    return [] if args.profiles_only else STABILISERS


def ratios(above, below):
    return [a / b for a, b in zip(above, below)]


def summary(found):
    mean = sum(found) / len(found)
    variance = sum((value - mean) ** 2 for value in found) / (len(found) - 1)
    return mean, math.sqrt(variance / len(found))


def heading(args):
    info = json.loads(run(args.pt, "info", "--json"))["devices"][0]["device"]
    scenes = " ".join(pathlib.Path(scene).name for scene in args.scenes)
    only = " --profiles-only" if args.profiles_only else ""
    yield (f"`scripts/energy_table.py --size {args.size} --frames {args.frames} --seeds {args.seeds} --spp {args.spp} --bounces {args.bounces}{only}"
           f" {scenes}`; {info['name']}.")
    yield ""


def rows(args, columns):
    def cell(value):
        return f"{value[0]:.4f} ± {value[1]:.4f}"

    scenes = args.scenes
    names = [pathlib.Path(scene).stem for scene in scenes]
    yield f"| energy over that of the reference | {' | '.join(names)} |"
    yield f"|{' --- |' * (len(names) + 1)}"
    for profile in ("unbiased", "q2rtx"):
        yield f"| profile `{profile}` | {' | '.join(cell(columns[scene][profile]) for scene in scenes)} |"
    for index, title in enumerate(("alone, over `unbiased`", "without, over `q2rtx`")):
        for key, *both in stabilisers(args):
            value = both[index]
            cells = [cell(columns[scene][key][index]) for scene in scenes]
            yield f"| `{key}={value}` {title} | {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
