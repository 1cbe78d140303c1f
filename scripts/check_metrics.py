#!/usr/bin/env python3
"""Checks the image metrics of pt against those of others on one moving sequence: FLIP and HDR-FLIP against flip-evaluator, and the order in
which FLIP and the temporal errors put denoisers against ColorVideoVDP.

usage: scripts/check_metrics.py [--pt target/release/pt] [--pt-denoise target/release/pt-denoise] [--scene gallery] [--camera tour]
                                [--size 96x54] [--frames 8..24] [--fps 15] [--spp 256] [--variants V,...] [--capture DIR]

Records the sequence with `pt capture`, runs the variants of the denoiser on it with `pt-denoise`, and compares every frame with its path
traced reference. --capture takes a folder that `pt capture --reference-spp` wrote, instead. Prints a table of values and the rank
correlations (Spearman; 1: the same order). Exit code 1: FLIP or HDR-FLIP of a frame differs from flip-evaluator by more than 0.002 + 1 %.

Needs: pip install flip-evaluator==1.7 OpenEXR==3.5.3 numpy. With cvvdp 0.5.7 (pip install cvvdp) too, the sequences are also judged by
ColorVideoVDP; it needs torch 2, of which the package of PyPI brings gigabytes of GPU libraries. On Debian 13: apt-get install python3-torch
python3-torchvision, then pip install --no-deps cvvdp and what it names. Without it the script says so and leaves these columns out.
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

# FLIP of ours may differ from another implementation by rounding and by how borders are filtered.
TOLERANCE, TOLERANCE_SHARE = 0.002, 0.01
PIXELS_PER_DEGREE = 3840 * math.pi / 180  # as in pt-image/src/metrics/flip


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--pt-denoise", default="target/release/pt-denoise")
    parser.add_argument("--scene", default="gallery")
    parser.add_argument("--camera", default="tour")
    parser.add_argument("--size", default="96x54")
    parser.add_argument("--frames", default="8..24")
    parser.add_argument("--fps", default="15")
    parser.add_argument("--spp", default="256")
    parser.add_argument("--variants", default="off,accumulate,svgf,asvgf,atrous,recurrent")
    parser.add_argument("--capture", type=pathlib.Path)
    args = parser.parse_args()
    try:
        global flip_evaluator, numpy, OpenEXR
        import flip_evaluator
        import numpy
        import OpenEXR
    except ImportError as missing:
        fail(f"{missing.name} is missing: pip install flip-evaluator==1.7 OpenEXR==3.5.3 numpy")
    with tempfile.TemporaryDirectory() as folder:
        rows = measure(args, pathlib.Path(folder))
    print_values(rows)
    print_correlations(rows)
    sys.exit(0 if agrees(rows) else 1)


def fail(message):
    print(f"check_metrics: {message}", file=sys.stderr)
    sys.exit(2)


def run(*command):
    try:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    except OSError as error:
        fail(f"{command[0]} cannot be run ({error.strerror}): build it, or name it with --pt and --pt-denoise")
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        fail(f"{' '.join(str(word) for word in command)}: {last}")
    return done.stdout


def measure(args, folder):
    """One row per variant and frame; the values of a whole sequence are in each of its rows."""
    capture = args.capture
    if capture is None:
        capture = folder / "capture"
        # With the profile realtime, whose denoiser is asvgf: the capture then has the gradient samples that asvgf needs.
        run(args.pt, "capture", args.scene, "--profile", "realtime", "--camera", args.camera, "--size", args.size, "--frames", args.frames,
            "--fps", args.fps, "--reference-spp", args.spp, "-o", capture)
    run(args.pt_denoise, capture, "--variant", args.variants, "--json", folder / "rows.jsonl", "--dump", folder)
    rows = [json.loads(line) for line in (folder / "rows.jsonl").read_text().splitlines()]
    sequences = {}
    for row in rows:
        image = folder / f"{row['variant']}_{row['frame']:06}.exr"
        truth = capture / f"reference_{row['frame']:06}.exr"
        if not truth.exists():
            fail(f"{truth} is missing: the capture needs --reference-spp")
        found = json.loads(run(args.pt, "compare", image, truth, "--metric", "flip,hdr-flip", "--json"))["metrics"]
        row["flip"], row["hdr_flip"] = found["flip"]["value"], found["hdr-flip"]["value"]
        test, reference = radiance(image), radiance(truth)
        displayed = display_values(test, reference)
        row["their_flip"] = evaluate(*displayed, "LDR")
        row["their_hdr_flip"] = evaluate(numpy.maximum(test, 0), numpy.maximum(reference, 0), "HDR")
        sequences.setdefault(row["variant"], []).append(displayed)
    judge = color_video_vdp(float(args.fps))
    for row in rows:
        row["jod"] = None
    for variant, frames in sequences.items():
        jod = judge(frames) if judge else None
        for row in rows:
            if row["variant"] == variant:
                row["jod"] = jod
    return rows


def radiance(path):
    channels = OpenEXR.File(str(path), separate_channels=True).parts[0].channels
    return numpy.stack([channels[name].pixels for name in "RGB"], axis=-1).astype(numpy.float32)


def display_values(test, reference):
    """sRGB codes of both, exposed by the reference: the transform that `pt compare` prints."""
    luminance = reference @ numpy.array([0.2126, 0.7152, 0.0722])
    exposure = 0.18 / math.exp(numpy.log(luminance[luminance > 0]).mean())

    def codes(image):
        exposed = numpy.maximum(image, 0).astype(numpy.float64) * exposure
        linear = exposed / (1 + exposed)
        return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055).astype(numpy.float32)

    return codes(test), codes(reference)


def evaluate(test, reference, kind):
    parameters = {"ppd": PIXELS_PER_DEGREE}
    return float(flip_evaluator.evaluate(reference, test, kind, applyMagma=False, parameters=parameters)[1])


def color_video_vdp(fps):
    """A function from frames to the quality in JOD (10: no difference is seen), or None."""
    try:
        import pycvvdp
    except ImportError as missing:
        print(f"ColorVideoVDP is left out: {missing.name} is missing (see --help)\n")
        return None
    metric = pycvvdp.cvvdp(display_name="standard_4k", quiet=True)

    def judge(frames):
        test, reference = (numpy.stack([frame[side] for frame in frames]) for side in (0, 1))
        return float(metric.predict(test, reference, dim_order="FHWC", frames_per_second=fps)[0])

    return judge


def by_variant(rows):
    variants = {}
    for row in rows:
        variants.setdefault(row["variant"], []).append(row)
    return variants


def mean(rows, key):
    values = [row[key] for row in rows if row.get(key) is not None]
    return sum(values) / len(values) if values else None


COLUMNS = [
    ("flip", "FLIP"),
    ("their_flip", "flip-evaluator"),
    ("hdr_flip", "HDR-FLIP"),
    ("their_hdr_flip", "flip-evaluator"),
    ("temporal_pixel", "temporal, pixel"),
    ("temporal_block", "temporal, block"),
    ("jod", "JOD (cvvdp)"),
]


def print_values(rows):
    print("| variant | " + " | ".join(name for _, name in COLUMNS) + " |")
    print("|---|" + "---:|" * len(COLUMNS))
    for variant, of in by_variant(rows).items():
        values = (mean(of, key) for key, _ in COLUMNS)
        print(f"| {variant} | " + " | ".join("-" if v is None else f"{v:.4f}" for v in values) + " |")
    frames = len({row["frame"] for row in rows})
    print(f"\nMeans over {frames} frames; JOD is of the whole sequence, and larger is better.\n")


def ranks(values):
    order = sorted(range(len(values)), key=values.__getitem__)
    found = [0.0] * len(values)
    start = 0
    while start < len(order):
        end = start
        while end + 1 < len(order) and values[order[end + 1]] == values[order[start]]:
            end += 1
        for place in range(start, end + 1):
            found[order[place]] = (start + end) / 2
        start = end + 1
    return found


def spearman(a, b):
    """Rank correlation; equal values share the mean of their ranks."""
    a, b = ranks(a), ranks(b)
    middle = (len(a) - 1) / 2
    product = sum((x - middle) * (y - middle) for x, y in zip(a, b))
    spread = math.sqrt(sum((x - middle) ** 2 for x in a) * sum((y - middle) ** 2 for y in b))
    return product / spread if spread else math.nan


def print_correlations(rows):
    print("| compared | over | rank correlation | largest difference |")
    print("|---|---|---:|---:|")
    for name, ours, theirs in (("FLIP and flip-evaluator", "flip", "their_flip"),
                               ("HDR-FLIP and flip-evaluator", "hdr_flip", "their_hdr_flip")):
        pairs = [(row[ours], row[theirs]) for row in rows]
        largest = max(abs(a - b) for a, b in pairs)
        print(f"| {name} | {len(rows)} frames of all variants | {spearman(*zip(*pairs)):.4f} | {largest:.5f} |")
    if rows[0]["jod"] is None:
        return
    variants = by_variant(rows).values()
    for key, name in (("flip", "FLIP"), ("hdr_flip", "HDR-FLIP"), ("temporal_pixel", "temporal error per pixel"),
                      ("temporal_block", "temporal error per block")):
        pairs = [(mean(of, key), 10 - of[0]["jod"]) for of in variants if mean(of, key) is not None]
        if len(pairs) > 2:
            print(f"| {name} and ColorVideoVDP (10 - JOD) | {len(pairs)} variants | {spearman(*zip(*pairs)):.4f} | |")


def agrees(rows):
    wrong = [
        (row, ours) for row in rows for ours in ("flip", "hdr_flip")
        if abs(row[ours] - row["their_" + ours]) > TOLERANCE + TOLERANCE_SHARE * row["their_" + ours]
    ]
    for row, ours in wrong[:5]:
        print(f"check_metrics: {ours} of {row['variant']}, frame {row['frame']}: {row[ours]:.5f}, "
              f"flip-evaluator {row['their_' + ours]:.5f}", file=sys.stderr)
    return not wrong


if __name__ == "__main__":
    main()
