#!/usr/bin/env python3
"""Every glTF scene below a folder, averaged frames beside the reference of the same size: FLIP and energy of each, the worst first.

usage: scripts/scenes_against_reference.py FOLDER OUT_FOLDER [--pt target/release/pt] [--size 256x192] [--frames 64] [--spp 256]
                                           [--env F] [--only TEXT] [--timeout 600] [--jobs 1] [RENDER ARGUMENTS...]

OUT_FOLDER gets NAME.exr (frames), NAME.reference.exr, table.md, and sheet.png with the pairs of pictures in the order of the table. Frames have the default profile, with fields that swap where glass is seen, and the bounces that it has; the reference has all.
RENDER ARGUMENTS follow after --, for example -- --set indirect.bounces=4. Pictures of scenes are made anew each time; none of them belongs into
the repository. FLIP is that of `pt compare`, of both images at the exposure of the reference. Exit code 1 when no scene could be compared.
"""

import argparse
import concurrent.futures
import json
import pathlib
import subprocess
import sys

FILES = (".gltf", ".glb")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--pt", default="target/release/pt")
    parser.add_argument("--size", default="256x192")
    parser.add_argument("--frames", default="64")
    parser.add_argument("--spp", default="256")
    parser.add_argument("--env")
    parser.add_argument("--only", help="only files whose path contains this")
    parser.add_argument("--timeout", type=float, default=600, help="seconds for one picture")
    parser.add_argument("--jobs", type=int, default=1, help="scenes that are rendered at the same time; on a GPU, where the host waits")
    parser.add_argument("render", nargs="*", help="more arguments of pt render, after --")
    args = parser.parse_args()
    if not args.folder.is_dir():
        sys.exit(f"scenes_against_reference: {args.folder} is not a folder")
    files = sorted(f for f in args.folder.rglob("*") if f.suffix in FILES and (args.only or "") in str(f))
    if not files:
        sys.exit(f"scenes_against_reference: no .gltf or .glb below {args.folder}")
    args.out.mkdir(parents=True, exist_ok=True)
    measured, failed = [], []
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as jobs:
        for name, row in jobs.map(lambda file: try_compare(args, file), files):
            if isinstance(row, str):
                failed.append((name, row))
                print(f"{name}: {row}")
            else:
                measured.append(row)
                print(f"{name}: FLIP {row['flip']:.4f}, energy {row['energy']:.4f}")
    if not measured:
        return 1
    measured.sort(key=lambda row: -row["flip"])
    table = ["| scene | FLIP | energy of the frames over that of the reference |", "| --- | --- | --- |"]
    table += [f"| {row['name']} | {row['flip']:.4f} | {row['energy']:.4f} |" for row in measured]
    table += [f"| {name} | - | {why} |" for name, why in failed]
    (args.out / "table.md").write_text("\n".join(table) + "\n")
    pictures = [args.out / f"{row['name']}{kind}.exr" for row in measured for kind in ("", ".reference")]
    run(args, "sheet", *pictures, "-o", args.out / "sheet.png", "--tile", args.size, "--columns", "4")
    mean = sum(row["flip"] for row in measured) / len(measured)
    print(f"{len(measured)} compared, {len(failed)} not; mean FLIP {mean:.4f}; {args.out / 'table.md'}, {args.out / 'sheet.png'}")
    return 0


class Failure(Exception):
    pass


def run(args, *command):
    command = [args.pt, *(str(part) for part in command)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=args.timeout)
    if done.returncode != 0:
        errors = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
        raise Failure((errors or [f"exit code {done.returncode}"])[0])
    return done.stdout


def name_of(file):
    """Folders tell apart files of the same name."""
    folder = file.parent.name
    return folder if folder == file.stem else f"{folder}_{file.stem}"


def try_compare(args, file):
    """Name and row of a scene; text instead of the row where it failed."""
    name = name_of(file)
    try:
        return name, compare(args, file, name)
    except subprocess.TimeoutExpired:
        return name, f"took more than {args.timeout:.0f} s"
    except Failure as failure:
        return name, str(failure)


def compare(args, file, name):
    frames, reference = args.out / f"{name}.exr", args.out / f"{name}.reference.exr"
    view = ["--size", args.size, *(["--env", args.env] if args.env else [])]
    still = ["--set", "gbuffer.alternate_fields=true", "--set", "checkerboard.blend_split=false"]
    run(args, "render", file, *view, "--frames", args.frames, "--accumulate", *still, *args.render, "-o", frames)
    run(args, "reference", file, *view, "--spp", args.spp, "--no-aov", "-o", reference)
    values = json.loads(run(args, "compare", frames, reference, "--metric", "flip,energy", "--json"))["metrics"]
    return {"name": name, "flip": values["flip"]["value"], "energy": values["energy"]["value"]}


if __name__ == "__main__":
    sys.exit(main())
