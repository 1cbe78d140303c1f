#!/usr/bin/env python3
"""Reads a capture of `pt capture` with the OpenEXR module: python3 examples/read_capture.py DIR

Prints for every frame where the camera is, the channels with their mean, and the error of the frame against its reference.
"""
import json
import pathlib
import sys

import numpy
import OpenEXR

folder = pathlib.Path(sys.argv[1])
index = json.loads((folder / "index.json").read_text())
print(f"{index['scene']}, recorded by pt {index['version']}")
for entry in index["frames"]:
    sidecar = json.loads((folder / entry["sidecar"]["name"]).read_text())
    eye = sidecar["camera"]["world_from_view"][12:15]
    print(f"frame {entry['frame']}: {sidecar['size']} pixels, eye at {eye}")
    channels = {}
    for part in OpenEXR.File(str(folder / entry["images"]["name"]), separate_channels=True).parts:
        channels.update({name: channel.pixels for name, channel in part.channels.items()})
    for name in sorted(channels):
        print(f"  {name:24} {channels[name].shape} mean {channels[name].astype(float).mean():.5g}")
    if entry["reference"]:
        truth = OpenEXR.File(str(folder / entry["reference"]["name"]), separate_channels=True).channels()
        error = [channels[f"flat_color.{c}"] - truth[c].pixels for c in "RGB"]
        print(f"  MSE against the reference {numpy.mean(numpy.square(error)):.5g}")
