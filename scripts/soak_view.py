#!/usr/bin/env python3
"""Runs `pt view` with random input on an X server without a screen, and fails if it crashes, if the validation layers say something, or if memory grows.

usage: scripts/soak_view.py [--pt target/release/pt] [--minutes 30] [--seed 1] [--scene flicker] [--size 160x90] [--most-growth 1]
                            [-- MORE OPTIONS OF pt view]

It needs Xvfb (scripts/setup-xvfb.sh) and xdotool (apt-get install xdotool). Input is keys, drags in the picture and on the panel, the wheel, text, other
sizes of the window, and a window that is hidden for a while; in the end Ctrl Q closes the window. The same seed draws the same input.

The first third of the time runs with the validation layers, the rest without: the layers keep notes of all objects that were ever made, so that memory grows with
them. Each run prints resident memory at its start, each minute and at its end, its slope over the second half, and the line that `pt view` ends with: frames,
frame rate, and how long input waited. Exit code 1: a crash, a message of the validation layers, or, without them, a slope of more than MOST_GROWTH MiB a
minute; runs of less than ten minutes are too short for it, because kernels are still compiled for knobs that were not turned before. Exit code 2: something is missing.
"""

import argparse
import os
import random
import shutil
import subprocess
import sys
import tempfile
import threading
import time


KEYS = ["space", "period", "r", "t", "c", "p", "g", "1", "2", "3", "h", "ctrl+z", "ctrl+y", "k"]
HELD = ["w", "a", "s", "d", "e", "q", "f", "shift"]


class Display:
    """Xvfb, and xdotool on it."""

    def __init__(self):
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", "1", "-screen", "0", "1600x1000x24", "-nolisten", "tcp", "-noreset"],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self.name = ":" + self.server.stdout.readline().strip()
        self.environment = {key: value for key, value in os.environ.items() if not key.startswith("WAYLAND")}
        self.environment["DISPLAY"] = self.name
        while not self.do("getdisplaygeometry"):
            time.sleep(0.1)

    def do(self, *words):
        done = subprocess.run(["xdotool", *map(str, words)], env=self.environment, capture_output=True, text=True)
        return done.stdout.strip()

    def close(self):
        self.server.terminate()
        self.server.wait()


def resident(pid):
    """MiB."""
    with open(f"/proc/{pid}/status") as file:
        for line in file:
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
    return 0.0


def slope(samples):
    """MiB a minute: least squares over the second half, after caches are full."""
    half = samples[len(samples) // 2 :]
    if len(half) < 2:
        return 0.0
    x = [seconds / 60 for seconds, _ in half]
    y = [memory for _, memory in half]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    variance = sum((a - mean_x) ** 2 for a in x)
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / variance if variance else 0.0


def act(display, window, dice):
    """One random thing that a user may do."""
    width, height = dice.choice([(480, 300), (700, 500), (1200, 800), (330, 200)])
    at = dice.randrange(0, 1000), dice.randrange(0, 700)
    kind = dice.choices(["key", "hold", "drag", "wheel", "click", "size", "hide", "type"], [6, 3, 4, 2, 8, 1, 1, 1])[0]
    if kind == "key":
        display.do("key", dice.choice(KEYS))
    elif kind == "hold":
        keys = dice.sample(HELD, 2)
        display.do("keydown", keys[0], "keydown", keys[1], "sleep", 0.3, "keyup", keys[0], "keyup", keys[1])
    elif kind == "drag":
        button = dice.choice([1, 2, 3])
        steps = [word for _ in range(6) for word in ("mousemove_relative", "--", dice.randrange(-40, 40), dice.randrange(-30, 30), "sleep", 0.02)]
        display.do("mousemove", *at, "sleep", 0.05, "mousedown", button, *steps, "mouseup", button)
    elif kind == "wheel":
        display.do("mousemove", *at, "click", "--repeat", dice.randrange(1, 6), dice.choice([4, 5]))
    elif kind == "click":
        display.do("mousemove", *at, "sleep", 0.1, "click", 1)
    elif kind == "size":
        display.do("windowsize", window, width, height)
    elif kind == "hide":
        display.do("windowunmap", window, "sleep", 0.5, "windowmap", window, "sleep", 0.2, "windowfocus", window)
    elif kind == "type":
        display.do("type", "--delay", 20, dice.choice(["sun", "1.5", "-3"]))
    return kind


def close(display, window, process, patience):
    """Ctrl Q until it ends: a field of the panel may have the keys."""
    end = time.monotonic() + patience
    while process.poll() is None and time.monotonic() < end:
        display.do("windowmap", window, "sleep", 0.2, "windowfocus", window, "key", "Escape", "sleep", 0.2, "key", "ctrl+q")
        try:
            process.wait(2)
        except subprocess.TimeoutExpired:
            pass
    return process.poll()


def soak(args, display, folder, minutes, validates):
    """One run; whether it went well."""
    command = [args.pt, "view", args.scene, "--size", args.size, "--profile", "realtime", "--device", args.device, "--play"]
    command += ["--validation"] * validates + ["--frames", "4", "--folder", folder, *args.more]
    print(" ".join(command), flush=True)
    process = subprocess.Popen(command, env=display.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    said = {"out": [], "err": []}
    readers = [
        threading.Thread(target=lambda stream=stream, name=name: said[name].extend(stream), daemon=True)
        for name, stream in (("out", process.stdout), ("err", process.stderr))
    ]
    for reader in readers:
        reader.start()
    window, begin = "", time.monotonic()
    while not window and process.poll() is None and time.monotonic() - begin < 300:
        window = display.do("search", "--onlyvisible", "--name", "^pt view").split("\n")[0]
        time.sleep(0.2)
    samples, actions = [], {}
    if window:
        # The kernels are compiled behind the window.
        display.do("windowfocus", window)
        time.sleep(args.settle)
        dice, begin, next_sample, next_line = random.Random(args.seed), time.monotonic(), 0.0, 0.0
        while process.poll() is None and (now := time.monotonic() - begin) < minutes * 60:
            if now >= next_sample:
                samples.append((now, resident(process.pid)))
                next_sample += 10
            if now >= next_line:
                print(f"{now / 60:6.1f} min  {samples[-1][1]:8.1f} MiB  {sum(actions.values())} inputs", flush=True)
                next_line += 60
            kind = act(display, window, dice)
            actions[kind] = actions.get(kind, 0) + 1
            # What keys wrote is not needed.
            if sum(actions.values()) % 50 == 0:
                clear(folder)
            time.sleep(dice.uniform(0.02, 0.2))
        if process.poll() is None:
            now = time.monotonic() - begin
            samples.append((now, resident(process.pid)))
            print(f"{now / 60:6.1f} min  {samples[-1][1]:8.1f} MiB  the end", flush=True)
    ended_early = process.poll() is not None
    code = close(display, window, process, args.patience) if window else None
    if code is None:
        process.kill()
        process.wait()
    for reader in readers:
        reader.join(5)
    print(f"inputs: {', '.join(f'{count} {kind}' for kind, count in sorted(actions.items()))}")
    summary = [line.strip() for line in said["out"] if "frames per second" in line]
    print(*(summary or ["no summary"]), sep="\n")
    growth = slope(samples)
    limit = "not judged" if validates else f"limit {args.most_growth:g}"
    print(f"slope over the second half: {growth:+.2f} MiB a minute ({limit})", flush=True)
    problems = []
    if not window:
        problems.append("there was no window")
    elif ended_early:
        problems.append(f"pt view ended before its time, exit code {code}")
    elif code is None:
        problems.append(f"Ctrl Q did not close the window in {args.patience:g} s")
    elif code:
        problems.append(f"exit code {code}")
    if any("validation" in line.lower() or "panicked" in line for line in said["err"]):
        problems.append("a message of the validation layers or a panic")
    if growth > args.most_growth and not validates:
        problems.append("memory grows")
    for problem in problems:
        print(f"soak_view: {problem}", file=sys.stderr)
    if problems:
        print("".join(said["err"][-20:]), file=sys.stderr)
    return not problems


def clear(folder):
    """Removes what has rested for a minute: captures are written frame by frame."""
    for entry in os.scandir(folder):
        if time.time() - entry.stat().st_mtime > 60:
            shutil.rmtree(entry.path) if entry.is_dir() else os.remove(entry.path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pt", default="target/release/pt", help="the program")
    parser.add_argument("--minutes", type=float, default=30, help="minutes of input")
    parser.add_argument("--seed", type=int, default=1, help="of the input")
    parser.add_argument("--scene", default="flicker")
    parser.add_argument("--size", default="160x90", help="of the picture")
    parser.add_argument("--device", default="cpu", help="as pt view takes it")
    parser.add_argument("--settle", type=float, default=20, help="seconds before the first input")
    parser.add_argument("--patience", type=float, default=120, help="seconds in which the window must close")
    parser.add_argument("--most-growth", type=float, default=1, help="MiB a minute")
    parser.add_argument("more", nargs="*", help="more options of pt view, after --")
    args = parser.parse_args()
    for tool in ("Xvfb", "xdotool"):
        if not shutil.which(tool):
            print(f"soak_view: no {tool}; apt-get install xvfb xdotool", file=sys.stderr)
            return 2
    if not shutil.which(args.pt):
        print(f"soak_view: {args.pt} is no program; build it with cargo build --release -p pt-app, or give --pt", file=sys.stderr)
        return 2
    display = Display()
    try:
        with tempfile.TemporaryDirectory() as folder:
            went_well = [soak(args, display, folder, args.minutes * share, share < 0.5) for share in (1 / 3, 2 / 3)]
            return 0 if all(went_well) else 1
    finally:
        display.close()


if __name__ == "__main__":
    sys.exit(main())
