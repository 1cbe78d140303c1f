#!/usr/bin/env python3
"""Measures the denoisers on captures: still scenes, a light that is switched, a moving camera. Prints tables and puts them into a README.

usage: scripts/denoiser_table.py [--pt target/release/pt] [--pt-denoise target/release/pt-denoise] [--size 96x54] [--frames 64]
                                 [--spp 256] [--truth-frames 2048] [--seeds 3] [--jobs 1] [--seconds S] [--results F]
                                 [--parts still,switched,moving] [--readme pt-denoise/README.md] [SCENE...]

SCENE is a built-in scene or a glTF file of the part "still" [default: cornell gallery lamps kinds flicker]. The tables are put between the
markers of the README; with --readme - they are printed alone. Every value is a mean and its standard error over the seeds.

A cell is one part, scene and seed. --results F writes each into a file of JSON lines when it is done; cells that the file has are not run again. After
--seconds S no further program is started, and the tables have what is there: with 0, only what is in the file.

Still: time stands, no jitter and no lens. The ground truth is the mean of --truth-frames other frames of the same kind, with the two paths of glass left
in their fields: what is left is the error of the denoiser. Values are means over the last 8 frames. "Energy by channel" is that of the variant with one light channel
alone and white surfaces, over the energy of `accumulate`, which has the same input and leaves it where it is.
All variants but `asvgf` have a recording of their own, without gradient pixels; the energies by channel, and what is switched, are of one recording.
Switched: in `flicker` the alarm lamp goes out, or on, in frame 16, and everything else stands; ground truth as above. The recovery is the number of
frames from the switch on until the error is within 1.5 times a wanted one for three frames. Wanted is the error of a sequence in which the lamp never
changes: of its last 8 frames ("still"), or of as many frames after its beginning ("fresh": nothing that forgets all old light can be better). "Path traced":
with jitter, against pictures of --spp samples of each frame, the error of the still sequence in the same frame.
Moving: `gallery` along its camera path, 30 frames a second, with the jitter of the profile realtime; the ground truth of every frame is path traced with one
bounce and --spp samples. The first 8 frames do not count.
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
import threading
import time

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
RECOVERED = 1.5
PARTS = ["still", "switched", "moving"]


class OutOfTime(Exception):
    """No further program is started."""


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
    parser.add_argument("--seconds", type=float, default=math.inf)
    parser.add_argument("--results", type=pathlib.Path)
    parser.add_argument("--parts", default=",".join(PARTS))
    parser.add_argument("--readme", default="pt-denoise/README.md")
    args = parser.parse_args()
    args.parts = args.parts.split(",")
    for part in args.parts:
        if part not in PARTS:
            sys.exit(f"denoiser_table: --parts: {part} is none of {', '.join(PARTS)}")
    if args.seeds < 2:
        sys.exit("denoiser_table: --seeds: a standard error needs at least 2")
    if args.frames < SWITCH + LAST:
        sys.exit(f"denoiser_table: --frames: at least {SWITCH + LAST}")
    if args.readme != "-":
        lines = pathlib.Path(args.readme).read_text().splitlines()
        for marker in (BEGIN, END):
            if marker not in lines:
                sys.exit(f"denoiser_table: {args.readme} has no line \"{marker}\"")
    args.end = time.monotonic() + args.seconds
    found, failed = measure(args)
    table = list(tables(args, found))
    print("\n".join(table))
    if args.readme != "-":
        first, last = lines.index(BEGIN), lines.index(END)
        text = [*lines[: first + 1], *table, *lines[last:]]
        pathlib.Path(args.readme).write_text("\n".join(text) + "\n")
    if failed:
        sys.exit(1)


def cells(args, folder):
    """Name and function of each cell; the first seed of all parts before the second."""
    for seed in range(1, args.seeds + 1):
        if "switched" in args.parts:
            for _, at in SWITCHES:
                yield f"switched {at} {seed}", lambda at=at, seed=seed: recovery(args, at, seed, folder)
        if "moving" in args.parts:
            yield f"moving {seed}", lambda seed=seed: moving_errors(args, seed, folder)
        if "still" in args.parts:
            for scene in args.scenes:
                yield f"still {scene} {seed}", lambda scene=scene, seed=seed: still_errors(args, scene, seed, folder)


def measure(args):
    """What the cells found, by name, and whether some failed."""
    conditions = {"size": args.size, "frames": args.frames, "spp": args.spp, "truth_frames": args.truth_frames}
    rows, failed = [], False
    if args.results and args.results.exists():
        try:
            rows = [json.loads(line) for line in args.results.read_text().splitlines()]
            _ = [(row["cell"], row["conditions"], row["device"], row["found"]) for row in rows]
        except (ValueError, KeyError, TypeError):
            sys.exit(f"denoiser_table: {args.results} is no file that --results wrote; name another")
    found = {row["cell"]: row for row in rows if row["conditions"] == conditions}
    if args.seconds <= 0:
        return found, failed
    device = json.loads(run(args, args.pt, "info", "--json"))["devices"][0]["device"]["name"]
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(args.jobs) as jobs:
        running = {jobs.submit(cell): name for name, cell in cells(args, pathlib.Path(folder)) if name not in found}
        for future in concurrent.futures.as_completed(running):
            try:
                row = {"cell": running[future], "conditions": conditions, "device": device, "found": future.result()}
            except OutOfTime:
                continue
            except RuntimeError as error:
                print(f"denoiser_table: {running[future]}: {error}", file=sys.stderr)
                failed = True
                continue
            found[row["cell"]] = row
            rows.append(row)
            if args.results:
                written = args.results.with_name(args.results.name + ".new")
                written.write_text("".join(json.dumps(row) + "\n" for row in rows))
                written.replace(args.results)
    return found, failed


def run(args, *command):
    if time.monotonic() >= args.end:
        raise OutOfTime
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}\nexit {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def sets(knobs):
    return [part for knob in knobs for part in ("--set", knob)]


TRUTHS, TRUTHS_LOCK = {}, threading.Lock()


def truth(args, scene, at, folder):
    """The image of the mean of many frames at a time, seconds; the first cell that needs it makes it."""
    with TRUTHS_LOCK:
        lock, image = TRUTHS.setdefault((scene, at), (threading.Lock(), folder / f"truth_{len(TRUTHS)}.exr"))
    with lock:
        if not image.exists():
            # As pt-denoise shows frames: a pixel of a surface that reflects in one field and refracts in the other has one of both.
            knobs = [*STILL, "denoise.variant=off", "checkerboard.blend_split=false"]
            run(args, args.pt, "render", scene, "--profile", "realtime", "--accumulate", "--size", args.size, "--frames", args.truth_frames,
                "--time", at, "--seed", 1000, *sets(knobs), "-o", image)
    return image


def capture(args, scene, seed, folder, *more):
    run(args, args.pt, "capture", scene, "--profile", "realtime", "--size", args.size, "--frames", f"0..{args.frames}", "--seed", seed, *more,
        "-o", folder)


def denoise(args, recorded, *more, variants=VARIANTS):
    """Rows of the JSON file by variant, in the order of the frames."""
    lines = pathlib.Path(f"{recorded}.jsonl")
    run(args, args.pt_denoise, recorded, "--variant", ",".join(variants), "--json", lines, *more)
    rows = [json.loads(line) for line in lines.read_text().splitlines()]
    return {variant: [row for row in rows if row["variant"] == variant] for variant in variants}


def capture_both(args, scene, seed, folder, *more, traced=()):
    """Of `asvgf`, and of the others: gradient pixels show samples of the frame before, which another variant would count twice. `traced`: for one of them."""
    capture(args, scene, seed, folder / "asvgf", *more, *traced)
    capture(args, scene, seed, folder / "others", *more, "--set", "denoise.variant=svgf")


def denoise_both(args, folder, reference, *more, variants=VARIANTS):
    """As `denoise`, of what `capture_both` recorded."""
    more = ["--reference", reference, *more]
    others = [variant for variant in variants if variant != "asvgf"]
    return {**denoise(args, folder / "others", *more, variants=others), **denoise(args, folder / "asvgf", *more, variants=["asvgf"])}


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


def still_errors(args, scene, seed, folder):
    """Values by variant."""
    image = truth(args, scene, 0.0, folder)
    with tempfile.TemporaryDirectory(dir=folder) as own:
        return still_errors_against(args, scene, seed, image, pathlib.Path(own))


def still_errors_against(args, scene, seed, image, folder):
    capture_both(args, scene, seed, folder, "--fps", FROZEN, *sets(STILL))
    # One more, because temporal errors need the frame before.
    last = references(folder / "references", [image if i >= args.frames - LAST - 1 else None for i in range(args.frames)])
    rows = denoise_both(args, folder, last)
    found = {}
    for variant, of in rows.items():
        found[variant] = {key: mean(of[-LAST:], key) for key in ("relmse", "flip", "temporal_pixel", "energy_ratio")}
    for channel in CHANNELS:
        # Of light that is blurred over an edge, the albedo of the other side would count.
        alone = ["fixed_albedo=1", *(f"scale_{other}={int(other == channel)}" for other in [*CHANNELS, "overlay"])]
        rows = denoise(args, folder / "asvgf", "--reference", last, *sets(alone), variants=FILTERS)
        energy = {variant: mean(of[-LAST:], "energy_ratio") for variant, of in rows.items()}
        for variant in FILTERS:
            has_light = energy["accumulate"] > 0
            found[variant][channel] = energy[variant] / energy["accumulate"] if has_light else math.nan
    return found


def recovery(args, at, seed, folder):
    """By variant and error: of the still sequence; in the frame of the switch and after, over it; frames until it has recovered, None: never."""
    variants = ["accumulate", "svgf", "asvgf"]
    before, after = (truth(args, "flicker", at + sign * 0.001, folder) for sign in (-1, 1))
    errors = {}
    with tempfile.TemporaryDirectory(dir=folder) as own:
        own = pathlib.Path(own)
        for name, start, fps, first in (("switched", at - (SWITCH - 0.5) / SWITCH_FPS, SWITCH_FPS, before), ("still", at + 0.001, FROZEN, after)):
            timing = ["--time", start, "--fps", fps]
            images = references(own / f"{name} references", [first] * SWITCH + [after] * (args.frames - SWITCH))
            capture(args, "flicker", seed, own / name, *timing, *sets(STILL))
            errors[name] = denoise(args, own / name, "--reference", images, variants=variants)
            traced = f"{name} traced"
            capture(args, "flicker", seed, own / traced, *timing, "--reference-spp", args.spp, "--reference-bounces", 1)
            errors[traced] = denoise(args, own / traced, variants=variants)
    found = {variant: {} for variant in variants}
    for variant in variants:
        for metric in ("relmse", "flip"):
            of = {name: [row[metric] for row in rows[variant]] for name, rows in errors.items()}
            switched = of["switched"][SWITCH:]
            # The median: single bright samples decide the mean of an error.
            last = statistics.median(of["still"][-LAST:])
            found[variant][metric] = {"still": last, "first": switched[0] / last, "fifth": switched[5] / last,
                                      "frames": recovered(switched, [last] * len(switched)), "frames_fresh": recovered(switched, of["still"]),
                                      "frames_traced": recovered(of["switched traced"][SWITCH:], of["still traced"][SWITCH:])}
    return found


def recovered(errors, wanted):
    """Frames until three errors on end are within RECOVERED times what is wanted of them."""
    within = [error <= RECOVERED * of for error, of in zip(errors, wanted)]
    return next((i for i in range(len(within) - 2) if all(within[i : i + 3])), None)


def moving_errors(args, seed, folder):
    """By variant: errors of all pixels, of disoccluded ones, of the others."""
    with tempfile.TemporaryDirectory(dir=folder) as own:
        own = pathlib.Path(own)
        traced = ["--reference-spp", args.spp, "--reference-bounces", 1]
        capture_both(args, "gallery", seed, own, "--camera", "tour", "--fps", 30, traced=traced)
        by_variant = denoise_both(args, own, own / "asvgf")
    found = {}
    for variant, rows in by_variant.items():
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


def tables(args, found):
    """The lines of all tables, of the cells that are there."""
    def of(part):
        return [found[name]["found"] for name in (f"{part} {seed}" for seed in range(1, args.seeds + 1)) if name in found]

    devices = sorted({row["device"] for row in found.values()})
    what = " ".join(pathlib.Path(scene).name for scene in args.scenes) if "still" in args.parts else ""
    if args.parts != PARTS:
        what = f"--parts {','.join(args.parts)} {what}".strip()
    yield (f"`scripts/denoiser_table.py --size {args.size} --frames {args.frames} --spp {args.spp} --truth-frames {args.truth_frames} "
           f"--seeds {args.seeds} {what}`; {', '.join(devices) or 'not measured yet'}. Mean and standard error over the seeds; a value without one is of a single seed.")
    yield ""
    scenes = {pathlib.Path(scene).stem: of(f"still {scene}") for scene in args.scenes}
    scenes = {name: seeds for name, seeds in scenes.items() if seeds}
    if "still" in args.parts and scenes:
        yield from still_table(list(scenes), scenes)
    switched = {at: of(f"switched {at}") for _, at in SWITCHES}
    if "switched" in args.parts and any(switched.values()):
        yield from switch_table(switched, args)
    moving = of("moving")
    if "moving" in args.parts and moving:
        yield from moving_table(moving)


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


def switch_table(found, args):
    yield (f"**Switched**: `flicker`, the alarm lamp. Frames until the error is within {RECOVERED} times that of a still sequence, of a fresh one that "
           f"begins with the switch, and of a still one against path traced pictures of {args.spp} samples, whose noise counts in both.")
    yield ""
    yield "| lamp | error | variant | still | at once, over still | after 5 frames | frames: still | fresh | path traced |"
    yield f"|{' --- |' * 9}"

    def frames(values):
        if None in values:
            return f"more than {args.frames - SWITCH}"
        # All seeds alike: a whole number.
        return str(values[0]) if values and len(set(values)) == 1 else summary(values)

    for what, at in SWITCHES:
        for metric, name in (("relmse", "relMSE"), ("flip", "FLIP")):
            for variant in ("accumulate", "svgf", "asvgf"):
                of = {key: [seed[variant][metric][key] for seed in found[at]] for key in found[at][0][variant][metric]} if found[at] else {}
                cells = [summary(of.get(key, [])) for key in ("still", "first", "fifth")]
                cells += [frames(of.get(key, [])) for key in ("frames", "frames_fresh", "frames_traced")]
                yield f"| {what} | {name} | `{variant}` | {' | '.join(cells)} |"
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
    for other in ("svgf", "accumulate"):
        cells = [summary([of["asvgf"][key] - of[other][key] for of in found]) for key in ("flip", "new", "others", "relmse", "temporal")]
        yield f"| `asvgf` less `{other}` | {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
