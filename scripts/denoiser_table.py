#!/usr/bin/env python3
"""Measures the denoisers on captures: still scenes, a light that is switched, a moving camera. Prints tables and puts them into a README.

usage: scripts/denoiser_table.py [--pt target/release/pt] [--pt-denoise target/release/pt-denoise] [--size 96x54] [--frames 64]
                                 [--spp 256] [--truth-frames 2048] [--seeds 3] [--jobs 1] [--readme pt-denoise/README.md] [SCENE...]

SCENE is a built-in scene or a glTF file [default: cornell gallery lamps kinds flicker]. The tables are put between the markers of the
README; with --readme - they are printed alone. Every value is a mean and its standard error over the seeds.

Still: time stands, no jitter and no lens. The ground truth is the mean of --truth-frames other frames of the same kind: what is left is
the error of the denoiser. Values are means over the last 8 frames. "Energy by channel" is that of the variant with one light channel
alone and white surfaces, over the energy of `accumulate`, which has the same input and leaves it where it is.
Switched and moving: with the jitter of the profile realtime; the ground truth of every frame is path traced with one bounce and --spp samples.
In `flicker` the alarm lamp goes out, or on, in frame 16, and everything else stands. The recovery is the number of frames from the switch
on until the error is within 1.5 times that of the scene in which the lamp never changed, for three frames. `gallery` is seen along its
camera path, 30 frames a second; the first 8 frames do not count.
"""

import argparse
import concurrent.futures
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

BEGIN = "<!-- denoisers on captures: generated, see scripts/denoiser_table.py -->"
END = "<!-- end of denoisers on captures -->"
VARIANTS = ["off", "accumulate", "atrous", "recurrent", "svgf", "asvgf"]
FILTERS = ["accumulate", "recurrent", "svgf", "asvgf"]
CHANNELS = ["hf", "spec", "lf"]
LAST = 8
# Frames a second at which nothing moves within a sequence.
FROZEN = "1000000000"
STILL = ["gbuffer.jitter=none", "gbuffer.depth_of_field=false"]
SWITCH, SWITCH_FPS = 16, 60000
# When the alarm lamp of flicker changes, seconds.
SWITCHES = [("goes out", 0.4), ("goes on", 0.8)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=["cornell", "gallery", "lamps", "kinds", "flicker"])
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--pt-denoise", default="target/release/pt-denoise")
    parser.add_argument("--size", default="96x54")
    parser.add_argument("--frames", type=int, default=64)
    parser.add_argument("--spp", default="256")
    parser.add_argument("--truth-frames", default="2048")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=1, help="programs that run at the same time; on a GPU, where the host waits")
    parser.add_argument("--readme", default="pt-denoise/README.md")
    args = parser.parse_args()
    if args.seeds < 2:
        sys.exit("denoiser_table: --seeds: a standard error needs at least 2")
    if args.frames < SWITCH + LAST:
        sys.exit(f"denoiser_table: --frames: at least {SWITCH + LAST}")
    if args.readme != "-":
        lines = pathlib.Path(args.readme).read_text().splitlines()
        for marker in (BEGIN, END):
            if marker not in lines:
                sys.exit(f"denoiser_table: {args.readme} has no line \"{marker}\"")
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(args.jobs) as jobs:
        table = [*heading(args), *measure(args, pathlib.Path(folder), jobs)]
    print("\n".join(table))
    if args.readme == "-":
        return
    first, last = lines.index(BEGIN), lines.index(END)
    text = [*lines[: first + 1], *table, *lines[last:]]
    pathlib.Path(args.readme).write_text("\n".join(text) + "\n")


def measure(args, folder, jobs):
    """The lines of all tables."""
    seeds = range(1, args.seeds + 1)
    truths = {scene: jobs.submit(truth, args, scene, 0.0, folder / f"truth_{number}.exr") for number, scene in enumerate(args.scenes)}
    for future in truths.values():
        future.result()
    still = {scene: [jobs.submit(still_errors, args, scene, truths[scene].result(), seed, folder / f"still_{number}_{seed}") for seed in seeds]
             for number, scene in enumerate(args.scenes)}
    switched = {time: [jobs.submit(recovery, args, time, seed, folder / f"switch_{time}_{seed}") for seed in seeds] for _, time in SWITCHES}
    moving = [jobs.submit(moving_errors, args, seed, folder / f"moving_{seed}") for seed in seeds]
    names = [pathlib.Path(scene).stem for scene in args.scenes]
    found = {name: [future.result() for future in still[scene]] for name, scene in zip(names, args.scenes)}
    yield from still_table(names, found)
    yield from switch_table({time: [future.result() for future in of] for time, of in switched.items()})
    yield from moving_table([future.result() for future in moving])


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"denoiser_table: {' '.join(map(str, command))}\nexit {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def sets(knobs):
    return [part for knob in knobs for part in ("--set", knob)]


def truth(args, scene, time, image):
    """The mean of many frames."""
    knobs = [*STILL, "denoise.variant=off", "gbuffer.alternate_fields=true", "checkerboard.blend_split=false"]
    run(args.pt, "render", scene, "--profile", "realtime", "--accumulate", "--size", args.size, "--frames", args.truth_frames, "--time", time,
        "--seed", 1000, *sets(knobs), "-o", image)
    return image


def capture(args, scene, seed, folder, *more):
    run(args.pt, "capture", scene, "--profile", "realtime", "--size", args.size, "--frames", f"0..{args.frames}", "--seed", seed, *more, "-o", folder)


def denoise(args, recorded, *more, variants=VARIANTS):
    """Rows of the JSON file by variant, in the order of the frames."""
    lines = pathlib.Path(f"{recorded}.jsonl")
    run(args.pt_denoise, recorded, "--variant", ",".join(variants), "--json", lines, *more)
    rows = [json.loads(line) for line in lines.read_text().splitlines()]
    return {variant: [row for row in rows if row["variant"] == variant] for variant in variants}


def references(folder, images):
    """A folder in which frame i has the ground truth images[i], if that is one."""
    folder.mkdir()
    for frame, image in enumerate(images):
        if image:
            (folder / f"reference_{frame:06}.exr").symlink_to(image)
    return folder


def mean(rows, key):
    values = [row[key] for row in rows if row[key] is not None]
    return sum(values) / len(values) if values else math.nan


def still_errors(args, scene, image, seed, folder):
    """Values by variant."""
    folder.mkdir()
    recorded = folder / "capture"
    capture(args, scene, seed, recorded, "--fps", FROZEN, *sets(STILL))
    # One more, because temporal errors need the frame before.
    last = references(folder / "references", [image if i >= args.frames - LAST - 1 else None for i in range(args.frames)])
    rows = denoise(args, recorded, "--reference", last)
    found = {}
    for variant, of in rows.items():
        found[variant] = {key: mean(of[-LAST:], key) for key in ("relmse", "flip", "temporal_pixel", "energy_ratio")}
    for channel in CHANNELS:
        # Of light that is blurred over an edge, the albedo of the other side would count.
        alone = ["fixed_albedo=1", *(f"scale_{other}={int(other == channel)}" for other in [*CHANNELS, "overlay"])]
        rows = denoise(args, recorded, "--reference", last, *sets(alone), variants=FILTERS)
        energy = {variant: mean(of[-LAST:], "energy_ratio") for variant, of in rows.items()}
        for variant in FILTERS:
            has_light = energy["accumulate"] > 0
            found[variant][channel] = energy[variant] / energy["accumulate"] if has_light else math.nan
    return found


def recovery(args, time, seed, folder):
    """By variant: frames until it has recovered (or as many as there are), error before, in the frame of the switch, and after."""
    folder.mkdir()
    variants = ["accumulate", "svgf", "asvgf"]
    errors = {}
    for name, start in (("switched", time - (SWITCH - 0.5) / SWITCH_FPS), ("still", time + 0.001)):
        recorded = folder / name
        fps = SWITCH_FPS if name == "switched" else FROZEN
        capture(args, "flicker", seed, recorded, "--time", start, "--fps", fps, "--reference-spp", args.spp, "--reference-bounces", 1)
        rows = denoise(args, recorded, variants=variants)
        errors[name] = {variant: [row["relmse"] for row in of] for variant, of in rows.items()}
    found = {}
    for variant in variants:
        # The median: single bright samples decide the mean of an error.
        static = statistics.median(errors["still"][variant][-LAST:])
        after = errors["switched"][variant][SWITCH:]
        within = [error <= 1.5 * static for error in after]
        frames = next((i for i in range(len(after) - 2) if all(within[i : i + 3])), len(after))
        found[variant] = {"frames": frames, "static": static, "first": after[0] / static, "fifth": after[5] / static}
    return found


def moving_errors(args, seed, folder):
    """By variant: errors of all pixels, of disoccluded ones, of the others."""
    folder.mkdir()
    recorded = folder / "capture"
    capture(args, "gallery", seed, recorded, "--camera", "tour", "--fps", 30, "--reference-spp", args.spp, "--reference-bounces", 1)
    found = {}
    for variant, rows in denoise(args, recorded).items():
        rows = rows[min(8, args.frames // 2) :]
        apart = [row["disoccluded"] for row in rows if row["disoccluded"]]
        found[variant] = {"flip": mean(rows, "flip"), "relmse": statistics.median(row["relmse"] for row in rows),
                          "temporal": mean(rows, "temporal_pixel"), "new": mean(apart, "flip"), "others": mean(apart, "flip_others"),
                          "share": mean(apart, "share")}
    return found


def summary(values):
    values = [value for value in values if not math.isnan(value)]
    if not values:
        return "-"
    if len(values) == 1:
        return f"{values[0]:.3g}"
    middle = sum(values) / len(values)
    error = math.sqrt(sum((value - middle) ** 2 for value in values) / (len(values) - 1) / len(values))
    # As many digits as the error has a say in: two of it.
    digits = max(0, 1 - math.floor(math.log10(error))) if error > 0 else 4
    digits = min(digits, max(0, 3 - math.floor(math.log10(abs(middle))))) if middle else digits
    return f"{middle:.{digits}f} ± {error:.{digits}f}"


def heading(args):
    info = json.loads(run(args.pt, "info", "--json"))["devices"][0]["device"]
    scenes = " ".join(pathlib.Path(scene).name for scene in args.scenes)
    yield (f"`scripts/denoiser_table.py --size {args.size} --frames {args.frames} --spp {args.spp} --truth-frames {args.truth_frames} "
           f"--seeds {args.seeds} {scenes}`; {info['name']}. Mean and standard error over the seeds.")
    yield ""


def still_table(names, found):
    yield f"**Still**, last {LAST} frames. The quotients are those of each seed."
    yield ""
    yield f"| | {' | '.join(names)} |"
    yield f"|{' --- |' * (len(names) + 1)}"

    def row(title, value):
        cells = [summary([value(of) for of in found[name]]) for name in names]
        return f"| {title} | {' | '.join(cells)} |"

    for variant in VARIANTS:
        yield row(f"relMSE of `{variant}`", lambda of: of[variant]["relmse"])
    yield row("relMSE, `asvgf` over `off` (at most 0.067)", lambda of: of["asvgf"]["relmse"] / of["off"]["relmse"])
    yield row("relMSE, `asvgf` over `svgf` (at most 1.1)", lambda of: of["asvgf"]["relmse"] / of["svgf"]["relmse"])
    yield row("temporal error, `asvgf` over `off` (at most 0.1)", lambda of: of["asvgf"]["temporal_pixel"] / of["off"]["temporal_pixel"])
    for variant in VARIANTS:
        yield row(f"FLIP of `{variant}`", lambda of: of[variant]["flip"])
    for variant in ("off", "svgf", "asvgf", "recurrent"):
        yield row(f"energy of `{variant}` over the reference", lambda of: of[variant]["energy_ratio"])
    for channel in CHANNELS:
        for variant in ("svgf", "asvgf", "recurrent"):
            yield row(f"energy of `{variant}` over `accumulate`, {channel}", lambda of: of[variant][channel])
    yield ""


def switch_table(found):
    yield "**Switched**: `flicker`, the alarm lamp. Errors in units of the still one."
    yield ""
    yield "| lamp | variant | frames until recovered | still relMSE | error in the frame of the switch | five frames later |"
    yield f"|{' --- |' * 6}"
    for what, time in SWITCHES:
        for variant in ("accumulate", "svgf", "asvgf"):
            cells = [summary([of[variant][key] for of in found[time]]) for key in ("frames", "static", "first", "fifth")]
            yield f"| {what} | `{variant}` | {' | '.join(cells)} |"
    yield ""


def moving_table(found):
    share = summary([of["asvgf"]["share"] for of in found])
    yield f"**Moving**: `gallery`, camera `tour`. Disoccluded: {share} of the pixels."
    yield ""
    yield "| variant | FLIP | FLIP of disoccluded pixels | FLIP of the others | relMSE, median of frames | temporal error |"
    yield f"|{' --- |' * 6}"
    for variant in VARIANTS:
        cells = [summary([of[variant][key] for of in found]) for key in ("flip", "new", "others", "relmse", "temporal")]
        yield f"| `{variant}` | {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
