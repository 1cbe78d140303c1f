#!/usr/bin/env python3
"""Measures how times grow with pixels, triangles, lights and instances, for the chapter of the book. Run it on a GPU.

usage: scripts/growth.py [--pt target/release/pt] [--seconds 120] [--frames 24] [--size 1920x1080] [--most 1] [--json FILE] [--device D] [--out docs/src/generated]

Each row is `pt render field:COUNTS --size SIZE --frames FRAMES --profile realtime --timings F`, the built-in scene `field` with one count changed:
the median time of a frame on the device, the median time in which the host records it, and the time before the first frame. A row that
would not end within SECONDS, judged by the rows before it, is skipped and said so; so is one that does not fit into the device.
--most 0.01 leaves out counts above that part of the largest one, to try the script on a CPU device. OUT gets growth.json, growth.md (a sentence and a
table for each) and growth.svg; --json FILE draws what was measured before.
"""

import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

BASE = {"triangles": 100_000, "lights": 64, "instances": 100, "moving": 0}
SIZES = ["640x360", "1280x720", "1920x1080", "2560x1440", "3840x2160"]
# Dear ones last, so that a short time leaves out those.
AXES = {
    "pixels": SIZES,
    "lights": [64, 256, 1024, 4096, 16_384],
    "instances": [1, 10, 100, 1000, 10_000, 100_000],
    "moving instances": [1, 10, 100, 1000, 10_000, 100_000],
    "triangles": [10_000, 100_000, 1_000_000, 10_000_000],
}


def pixels(size):
    width, height = size.split("x")
    return int(width) * int(height)


def cases(axis, args):
    """Count, scene and size of each row."""
    for value in AXES[axis]:
        if axis == "pixels":
            yield pixels(value), BASE, value
        elif axis == "moving instances":
            yield value, BASE | {"instances": value, "moving": value}, args.size
        else:
            yield value, BASE | {axis: value}, args.size


def measure(args, counts, size, folder):
    path = folder / "timings.json"
    scene = "field:" + ",".join(f"{name}={count}" for name, count in counts.items())
    command = [args.pt, "render", scene, "--size", size, "--frames", str(args.frames), "--profile", "realtime"]
    command += ["--timings", str(path), "-o", str(folder / "frame.png")] + (["--device", args.device] if args.device else [])
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        return {"skipped": (done.stderr.strip() or str(done.returncode)).splitlines()[-1]}, None
    timings = json.loads(path.read_text())
    warm = timings["frames"][timings["warm_up_frames"] :]
    passes = sorted(timings["passes"], key=lambda row: -row["median_ms"])
    row = {
        "frame_ms": timings["frame"]["median_ms"],
        "record_ms": statistics.median(frame["record_ms"] for frame in warm),
        "load_s": timings["load"]["total_ms"] * 1e-3,
        "load": timings["load"]["phases"],
        "host_bytes": timings["load"]["peak_memory_bytes"],
        "dearest": [row["pass"] for row in passes[:3]],
    }
    return row, {name: timings[name] for name in ("device", "driver", "backend")}


def run(args):
    begin, found = time.monotonic(), {"axes": {}}
    with tempfile.TemporaryDirectory() as folder:
        for axis in AXES:
            rows, before = found["axes"].setdefault(axis, []), None
            largest = max(count for count, _, _ in cases(axis, args))
            for count, counts, size in cases(axis, args):
                row = {"count": count, "size": size, "scene": counts}
                rows.append(row)
                left = args.seconds - (time.monotonic() - begin)
                # At worst in proportion to the count.
                expected = before[1] * max(count / before[0], 1) if before else 0
                if count > args.most * largest and len(rows) > 1:
                    row["skipped"] = "left out by --most"
                elif expected > left or left <= 0:
                    row["skipped"] = f"{args.seconds:g} s were over"
                else:
                    start = time.monotonic()
                    values, device = measure(args, counts, size, pathlib.Path(folder))
                    row.update(values)
                    found.update(device or {})
                    before = (count, time.monotonic() - start)
                print(f"{axis} {count}: {row.get('skipped') or '%.3f ms' % row['frame_ms']}", file=sys.stderr, flush=True)
    found["command"] = f"scripts/growth.py --size {args.size} --frames {args.frames} --seconds {args.seconds:g} --most {args.most:g}"
    return found


def exponent(first, last, name):
    """Of the power of the count that joins the first and the last row."""
    return math.log(last[name] / first[name]) / math.log(last["count"] / first["count"])


def number(count):
    for unit, name in ((1_000_000, " M"), (1000, " k")):
        if count >= unit:
            return f"{count / unit:.3g}{name}"
    return str(count)


def markdown(found):
    device = f"{found.get('device', '')} ({found.get('driver', '')}), {found.get('backend', '')}"
    parts = [f"<!-- generated by scripts/growth.py -->\n`{found['command']}`; {device}."]
    for axis, rows in found["axes"].items():
        done = [row for row in rows if "skipped" not in row]
        parts.append(f"\n**{axis[0].upper()}{axis[1:]}.**")
        if len(done) > 1:
            first, last = done[0], done[-1]
            parts[-1] += (
                f" From {number(first['count'])} to {number(last['count'])} a frame goes from {first['frame_ms']:.3f} to {last['frame_ms']:.3f} ms,"
                f" as the power {exponent(first, last, 'frame_ms'):.2f} of the count; recording from {first['record_ms']:.3f} to {last['record_ms']:.3f} ms,"
                f" loading from {first['load_s']:.2f} to {last['load_s']:.2f} s."
            )
        parts.append(f"\n| {axis} | frame, ms | recording, ms | loading, s | dearest passes |\n| --- | --- | --- | --- | --- |")
        for row in rows:
            if "skipped" in row:
                parts.append(f"| {number(row['count'])} | - | - | - | {row['skipped']} |")
            else:
                parts.append(
                    f"| {number(row['count'])} | {row['frame_ms']:.3f} | {row['record_ms']:.3f} | {row['load_s']:.2f} | {', '.join(row['dearest'])} |"
                )
    return "\n".join(parts) + "\n"


def svg(found):
    """A panel for each count: times over it, both logarithmic; grey lines have slope 1."""
    side, gap, left, top = 200, 52, 46, 34
    columns = 3
    axes = [(axis, [row for row in rows if "skipped" not in row]) for axis, rows in found["axes"].items()]
    rows_of_panels = (len(axes) + columns - 1) // columns
    width, height = left + columns * (side + gap), top + rows_of_panels * (side + gap + 24)
    body = []
    lines = (("frame_ms", 1, "frame", "#1f6f8b"), ("record_ms", 1, "recording", "#c1666b"), ("load_s", 1000, "loading", "#8a8a8a"))
    values = [row[name] * unit for _, rows in axes for row in rows for name, unit, _, _ in lines if row[name] > 0]
    if not values:
        sys.exit("growth: nothing was measured")
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    for number_of, (axis, rows) in enumerate(axes):
        x0, y0 = left + (number_of % columns) * (side + gap), top + (number_of // columns) * (side + gap + 24)
        counts = [row["count"] for row in rows] or [1]
        a, b = math.log10(counts[0]), max(math.log10(counts[-1]), math.log10(counts[0]) + 1e-9)
        x = lambda count: x0 + side * (math.log10(count) - a) / (b - a)
        y = lambda ms: y0 + side * (high - math.log10(ms)) / (high - low)
        body.append(f'<rect x="{x0}" y="{y0}" width="{side}" height="{side}" class="panel"/>')
        body.append(f'<text x="{x0 + side / 2}" y="{y0 - 8}" class="name">{axis}</text>')
        for power in range(low, high + 1):
            at = y(10.0**power)
            body.append(f'<path d="M{x0} {at:.1f} h{side}" class="grid"/><text x="{x0 - 4}" y="{at + 4:.1f}" class="tick">{10.0**power:g} ms</text>')
        for count in counts:
            body.append(f'<text x="{x(count):.1f}" y="{y0 + side + 14}" class="count">{number(count)}</text>')
        for name, unit, label, color in lines:
            points = [(x(row["count"]), y(row[name] * unit)) for row in rows if row[name] > 0]
            if points:
                path = " ".join(f"{px:.1f},{py:.1f}" for px, py in points)
                body.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="2"/>')
                body += [f'<circle cx="{px:.1f}" cy="{py:.1f}" r="2.5" fill="{color}"/>' for px, py in points]
                if number_of == 0:
                    body.append(f'<text x="{points[-1][0] - 4:.1f}" y="{points[-1][1] - 6:.1f}" fill="{color}" text-anchor="end">{label}</text>')
        first = next((row for row in rows if row["frame_ms"] > 0), None)
        if first:
            # In proportion to the count, as far as it stays in the panel.
            end = min(b, a + high - math.log10(first["frame_ms"]))
            top_y = y(first["frame_ms"] * 10 ** (end - a))
            body.append(f'<path d="M{x0} {y(first["frame_ms"]):.1f} L{x0 + side * (end - a) / (b - a):.1f} {top_y:.1f}" class="slope"/>')
    style = (
        ".panel{fill:#fafafa;stroke:#999}.grid{stroke:#ddd}.slope{stroke:#bbb;stroke-dasharray:4 3}.name{font-weight:bold;text-anchor:middle}"
        ".tick{text-anchor:end;fill:#555;font-size:9px}.count{text-anchor:middle;fill:#555;font-size:9px}"
    )
    title = f"Times of a frame over counts. {found['command']}; {found.get('device', '')}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" font-family="sans-serif" font-size="11" role="img">'
        f"<title>{title}</title><style>{style}</style><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" + "\n".join(body) + "\n</svg>\n"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--seconds", type=float, default=120)
    parser.add_argument("--frames", type=int, default=24)
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--most", type=float, default=1)
    parser.add_argument("--device")
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent / "docs/src/generated")
    args = parser.parse_args()
    found = json.loads(args.json.read_text()) if args.json else run(args)
    text, figure = markdown(found), svg(found)
    args.out.mkdir(parents=True, exist_ok=True)
    (args.out / "growth.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    (args.out / "growth.md").write_text(text, encoding="utf-8")
    (args.out / "growth.svg").write_text(figure, encoding="utf-8")
    print(f"wrote growth.json, growth.md and growth.svg to {args.out}")


if __name__ == "__main__":
    main()
