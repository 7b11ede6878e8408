#!/usr/bin/env python3
"""The mean BRDF of microfacet conductors against Mitsuba 3, which shares no code with us.

    pip install mitsuba==3.9.1 numpy
    python tests/peers/mitsuba_mean_brdf.py target/release/fitter

Draws caps that do not cross the horizon and directions in the reflected lobe, averages Mitsuba's `roughconductor`
(eta = 0, k = 1, so that the Fresnel term is 1) over each cap with its cosine, and compares with `fitter query` of a freshly
fitted table. Prints the largest and the median difference over the peak; exit code 1 above 2 % and 0.3 %.
Skips, saying so, where Mitsuba is not installed.
"""
import csv
import io
import math
import subprocess
import sys
import tempfile

try:
    import mitsuba as mi
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(0)

mi.set_variant("scalar_rgb")
CASES = [("beckmann", 0.2, 0.2), ("beckmann", 0.1, 0.4), ("ggx", 0.1, 0.1), ("ggx", 0.3, 0.3), ("ggx", 0.1, 0.4)]
CAPS, VIEWS, RINGS, SPOKES = 12, 4, 24, 48


def spherical(theta, phi):
    return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


def frame(z):
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def mean(bsdf, axis, sigma, wo):
    """Gauss-Legendre rings of equal spokes over the cap."""
    to_local, context = frame(axis), mi.BSDFContext()
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(*wo)
    nodes, weights = np.polynomial.legendre.leggauss(RINGS)
    top = bottom = 0.0
    for node, weight in zip(nodes, weights):
        beta = 0.5 * sigma * (node + 1)
        for spoke in range(SPOKES):
            w = to_local @ spherical(beta, 2 * math.pi * (spoke + 0.5) / SPOKES)
            measure = weight * math.sin(beta)
            # Mitsuba's value carries the cosine.
            top += measure * bsdf.eval(context, si, mi.Vector3f(*w))[0]
            bottom += measure * w[2]
    return top / bottom


failed = False
rng = np.random.default_rng(1)
for model, ax, ay in CASES:
    bsdf = mi.load_dict({"type": "roughconductor", "distribution": model, "alpha_u": ax, "alpha_v": ay, "eta": 0.0, "k": 1.0})
    width = math.sqrt(2 * ax * ay)
    rows, expected = [], []
    for _ in range(CAPS):
        theta, phi = rng.uniform(0, 1.2), rng.uniform(0, 2 * math.pi)
        sigma = min(rng.uniform(0.1, 2.0) * width, 1.5 - theta)
        axis = spherical(theta, phi)
        for _ in range(VIEWS):
            wo = np.array([-axis[0], -axis[1], axis[2]]) + rng.normal(0, 0.5 * width, 3)
            wo[2] = max(wo[2], 0.1)
            wo /= np.linalg.norm(wo)
            rows.append([theta, phi, 2 * math.pi * (1 - math.cos(sigma)), *wo])
            expected.append(mean(bsdf, axis, sigma, wo))
    with tempfile.TemporaryDirectory() as folder:
        table = f"{folder}/peer.tbl"
        recipe = f"{model}:alpha_x={ax},alpha_y={ay}"
        subprocess.run([sys.argv[1], "fit", recipe, "-o", table], check=True, capture_output=True)
        text = io.StringIO()
        writer = csv.writer(text)
        writer.writerow("theta_e phi_e omega wo_x wo_y wo_z".split())
        writer.writerows(rows)
        answer = subprocess.run([sys.argv[1], "query", table], input=text.getvalue(), text=True, check=True, capture_output=True)
    found = [float(row["r"]) for row in csv.DictReader(io.StringIO(answer.stdout))]
    error = np.abs(np.array(found) - expected) / max(expected)
    print(f"{recipe}: largest {100 * error.max():.3f} %, median {100 * np.median(error):.3f} % of the peak, {len(found)} values")
    failed |= error.max() > 0.02 or np.median(error) > 0.003
sys.exit(1 if failed else 0)
