#!/usr/bin/env python3
"""Writes pt-scene/src/sun_illuminance.txt: illuminance of the sun on a surface that faces it, for the physical sky.

    pip install mitsuba numpy && scripts/sun_table.py > pt-scene/src/sun_illuminance.txt

Spectral radiance of the sun is that of Hosek and Wilkie 2013, "Adding a Solar-Radiance Function to the Hosek-Wilkie Skylight Model"; the
Mitsuba package carries their data. It is weighted with the CIE 1931 observer as Wyman, Sloan and Shirley 2013, "Simple Analytic
Approximations to the CIE XYZ Color Matching Functions", fit it.

Limb darkening is left out. The authors' code multiplies the data with a limb darkening of 1 at the centre, as if they were the radiance
there. They are the mean of the disc: extrapolated to no atmosphere, they give the solar illuminance constant (--check).
"""
import struct
import sys
from pathlib import Path

import mitsuba
import numpy as np

WAVELENGTHS = np.arange(320.0, 721.0, 40.0)  # of the data, nm
ELEVATIONS = [0, 0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 75, 90]  # degrees
ANGULAR_RADIUS = np.radians(0.533 / 2)
LUMENS_PER_WATT = 683.002
# Linear Rec. 709 from XYZ.
RGB_FROM_XYZ = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)


def tensors(path, wanted):
    """Tensors of a Mitsuba tensor file: magic, version, count, then for each its name, dimensions, type, offset and shape."""
    data = path.read_bytes()
    (count,) = struct.unpack_from("<I", data, 14)
    at, found = 18, {}
    for _ in range(count):
        (length,) = struct.unpack_from("<H", data, at)
        name = data[at + 2 : at + 2 + length].decode()
        dimensions, kind, offset = struct.unpack_from("<HBQ", data, at + 2 + length)
        at += 2 + length + 11
        shape = struct.unpack_from(f"<{dimensions}Q", data, at)
        at += 8 * dimensions
        if name in wanted:
            assert kind == 11, "64-bit floating point"
            found[name] = np.frombuffer(data, "<f8", int(np.prod(shape)), offset).reshape(shape)
    return [found[name] for name in wanted]


def observer(nm):
    """The colour matching functions x, y, z."""

    def lobe(mean, below, above):
        return np.exp(-0.5 * ((nm - mean) * np.where(nm < mean, below, above)) ** 2)

    x = 0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323) - 0.065 * lobe(501.1, 0.0490, 0.0382)
    y = 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322)
    z = 1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725)
    return np.array([x, y, z])


def main():
    path = Path(mitsuba.__file__).parent / "data/sunsky/sunsky_datasets.bin"
    # Turbidity, segment of the elevation, wavelength, coefficient of the cubic.
    (radiance,) = tensors(path, ["sun_rad_spec"])
    nm = np.arange(360.0, 831.0)
    solid_angle = np.pi * np.sin(ANGULAR_RADIUS) ** 2
    segments = radiance.shape[1]

    def spectrum(turbidity, elevation):
        segment = min(int(np.cbrt(elevation / (np.pi / 2)) * segments), segments - 1)
        x = elevation - (segment / segments) ** 3 * np.pi / 2
        return sum(radiance[turbidity - 1, segment, :, k] * x**k for k in range(4))

    def xyz(values):
        return LUMENS_PER_WATT * solid_angle * (observer(nm) @ np.interp(nm, WAVELENGTHS, values, right=0.0))

    if "--check" in sys.argv[1:]:
        # Langley's extrapolation: the logarithm is linear in the air mass, 1 / sin(elevation) for a high sun.
        elevations = np.radians([30.0, 45.0, 60.0, 90.0])
        logarithms = np.log([spectrum(1, e) for e in elevations])
        outside = np.exp(np.polyfit(1 / np.sin(elevations), logarithms, 1)[1])
        print(f"illuminance outside of the atmosphere: {xyz(outside)[1]:.0f} lux; published: 128 to 133 thousand lux")
        return

    print("Illuminance of the sun on a surface that faces it, lux, linear Rec. 709, written by scripts/sun_table.py from the data of")
    print("Hosek and Wilkie 2013 (copyright 2012-2013 Lukas Hosek and Alexander Wilkie, 3-clause BSD licence). A row is an elevation of the")
    print("sun in degrees, and red, green and blue for the turbidities 1 to 10.")
    for elevation in ELEVATIONS:
        colours = [RGB_FROM_XYZ @ xyz(spectrum(t, np.radians(elevation))) for t in range(1, 11)]
        # The orange of a low sun lies outside of Rec. 709.
        values = np.maximum(colours, 0.0).ravel()
        print(f"= {elevation:g}", *(f"{v:.1f}" for v in values))


if __name__ == "__main__":
    main()
