#!/usr/bin/env python3
"""Compares evaluation, density and sampling of RGL files with Mitsuba 3's plugin `measured`, on files written here.

Usage: mitsuba_measured.py MEASURED, the path of the example `measured` of brdf-tables
(cargo build --release -p brdf-tables --features measured --example measured).
"""

import math
import pathlib
import subprocess
import sys
import tempfile

try:
    import mitsuba as mi
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing} (pip install mitsuba==3.9.1 numpy)")
    sys.exit(0)

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "inputs"))
from make_measured import spherical, tensors

# Relative to the value, and to the largest value of the view: both are of single precision, and warps of narrow cells lose more.
TOLERANCE = 2e-3
PAIRS = 400


def smooth(rng, shape, low):
    """Positive numbers that vary by a factor of ten or so between nodes."""
    return (low + rng.random(shape) ** 2).astype("f4")


def write(path, rng, azimuths, bands):
    """Fields of no material, only smooth and positive: what is checked is that both read them alike."""
    zeniths = np.linspace(0, math.pi / 2, 6).astype("f4")
    views = (len(azimuths), len(zeniths))
    fields = {
        "description": np.frombuffer(b"made by mitsuba_measured.py", "u1"),
        "jacobian": np.array([1], "u1"),
        "phi_i": np.array(azimuths, "f4"),
        "theta_i": zeniths,
        "ndf": smooth(rng, (9, 12), 0.2),
        "sigma": smooth(rng, (7, 8), 0.3),
        "vndf": smooth(rng, (*views, 8, 10), 0.1),
        "luminance": smooth(rng, (*views, 7, 7), 0.2),
    }
    if bands is None:
        fields["rgb"] = smooth(rng, (*views, 3, 7, 7), 0.05)
    else:
        fields["wavelengths"] = np.array(bands, "f4")
        fields["spectra"] = smooth(rng, (*views, len(bands), 7, 7), 0.05)
    tensors(path, fields)


def compare(program, path, variant, spectral):
    mi.set_variant(variant)
    rng = np.random.default_rng(7)
    bsdf = mi.load_dict({"type": "measured", "filename": str(path)})
    wi = spherical(np.arccos(rng.uniform(0.05, 1, PAIRS)), rng.uniform(-math.pi, math.pi, PAIRS))
    wo = spherical(np.arccos(rng.uniform(0.05, 1, PAIRS)), rng.uniform(-math.pi, math.pi, PAIRS))
    u = rng.uniform(0.02, 0.98, (PAIRS, 2))
    rows = "\n".join(" ".join(f"{x:.9f}" for x in row) for row in np.hstack([wi, wo, u]))
    ours = subprocess.run([program, "rgl", str(path)], input=rows, capture_output=True, text=True, check=True).stdout
    ours = np.array([[float(x) for x in line.split()] for line in ours.splitlines()])
    worst = {"value": 0.0, "density": 0.0, "direction": 0.0, "sample density": 0.0, "sample value": 0.0}
    for k in range(PAIRS):
        si = mi.SurfaceInteraction3f()
        si.wi = mi.ScalarVector3f(*map(float, wo[k]))
        light = mi.ScalarVector3f(*map(float, wi[k]))
        value, density = bsdf.eval_pdf(mi.BSDFContext(), si, light)
        sample, weight = bsdf.sample(mi.BSDFContext(), si, 0.5, mi.ScalarPoint2f(*map(float, u[k])))
        near = lambda a, b: float(np.max(np.abs(np.array(a) - np.array(b)) / (np.abs(np.array(b)) + 1e-3)))
        if not spectral:
            worst["value"] = max(worst["value"], near(ours[k, :3], [value[c] for c in range(3)]))
        worst["density"] = max(worst["density"], near(ours[k, 3], density))
        direction = [sample.wo[c] for c in range(3)]
        if direction[2] > 1e-4 and ours[k, 6] > 1e-4:
            worst["direction"] = max(worst["direction"], float(np.abs(ours[k, 4:7] - direction).max()))
            worst["sample density"] = max(worst["sample density"], near(ours[k, 10], sample.pdf))
            if not spectral:
                worst["sample value"] = max(worst["sample value"], near(ours[k, 7:10], [weight[c] for c in range(3)]))
    return worst


def main():
    program, failed = sys.argv[1], False
    cases = [
        ("isotropic, RGB", [0.0], None),
        ("anisotropic, RGB, all azimuths", list(np.linspace(-math.pi, math.pi, 9)), None),
        ("anisotropic, RGB, half a turn", list(np.linspace(-math.pi, 0, 5)), None),
        ("anisotropic, RGB, a quarter", list(np.linspace(-math.pi, -math.pi / 2, 4)), None),
    ]
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, azimuths, bands) in enumerate(cases):
            path = pathlib.Path(folder) / f"{number}.bsdf"
            write(path, np.random.default_rng(number), azimuths, bands)
            worst = compare(program, path, "scalar_rgb", bands is not None)
            bad = max(worst.values()) > TOLERANCE
            failed |= bad
            print(f"{'FAILED' if bad else 'agrees'}  {name}: " + ", ".join(f"{k} {v:.1e}" for k, v in worst.items()))
    sys.exit(failed)


if __name__ == "__main__":
    main()
