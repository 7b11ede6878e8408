#!/usr/bin/env python3
"""Compares f_r of microfacet materials, and `fitter integrate` over random caps, with Mitsuba 3's roughconductor.

Usage: mitsuba_brdf.py FITTER, the path of the fitter program.
"""

import csv
import io
import math
import subprocess
import sys

try:
    import mitsuba as mi
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing} (pip install mitsuba==3.9.1 numpy)")
    sys.exit(0)

mi.set_variant("scalar_rgb")

# Recipe of the fitter, and properties of the plugin.
MATERIALS = [
    ("ggx:alpha=0.3", {"distribution": "ggx", "alpha": 0.3, "material": "none"}),
    ("ggx:alpha=0.1", {"distribution": "ggx", "alpha": 0.1, "material": "none"}),
    ("beckmann:alpha=0.2", {"distribution": "beckmann", "alpha": 0.2, "material": "none"}),
    ("ggx:alpha_x=0.1,alpha_y=0.4", {"distribution": "ggx", "alpha_u": 0.1, "alpha_v": 0.4, "material": "none"}),
    ("beckmann:alpha_x=0.4,alpha_y=0.15", {"distribution": "beckmann", "alpha_u": 0.4, "alpha_v": 0.15, "material": "none"}),
    ("ggx:alpha=0.25,eta=0.2,k=3.9", {"distribution": "ggx", "alpha": 0.25, "eta": 0.2, "k": 3.9}),
]
COLUMNS = ["theta_e", "phi_e", "omega", "wo_x", "wo_y", "wo_z"]
# f_r, relative: the peer computes in single precision.
POINT_TOLERANCE = 2e-4
# Standard errors of the two Monte Carlo estimates together, of which the peer's has 7 degrees of freedom.
SIGMAS = 6



def direction(theta, phi):
    return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


def around(axis, cos, phi):
    """Directions at angles of cosine `cos` and azimuth `phi` about a unit vector."""
    helper = np.array([1.0, 0.0, 0.0]) if abs(axis[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = np.cross(axis, helper)
    x /= np.linalg.norm(x)
    y = np.cross(axis, x)
    sin = np.sqrt(1 - cos**2)
    return np.outer(sin * np.cos(phi), x) + np.outer(sin * np.sin(phi), y) + np.outer(cos, axis)


def value(bsdf, wi, wo):
    """f_r in 1/sr: the plugin's value without its cosine, which belongs to its `wo`, our light."""
    si = mi.SurfaceInteraction3f()
    si.wi = mi.ScalarVector3f(*map(float, wo))
    return float(bsdf.eval(mi.BSDFContext(), si, mi.ScalarVector3f(*map(float, wi)))[0]) / wi[2]


def peer_mean(bsdf, row, rng, replicates=8, side=20):
    """Mean BRDF and its standard error: uniform stratified samples of the cap, replicated."""
    theta, phi, omega = row[:3]
    means = []
    for _ in range(replicates):
        u, v = np.meshgrid(np.arange(side), np.arange(side))
        u, v = ((g.ravel() + rng.random(side * side)) / side for g in (u, v))
        wi = around(direction(theta, phi), 1 - u * omega / (2 * math.pi), 2 * math.pi * v)
        lit = wi[wi[:, 2] > 1e-6]
        means.append(sum(value(bsdf, w, row[3:]) * w[2] for w in lit) / lit[:, 2].sum())
    return np.mean(means), np.std(means, ddof=1) / math.sqrt(replicates)


def run(fitter, arguments, rows):
    text = "\n".join([",".join(COLUMNS)] + [",".join(map(repr, map(float, row))) for row in rows]) + "\n"
    done = subprocess.run([fitter, *arguments], input=text, capture_output=True, text=True, check=True)
    return [{k: float(x) for k, x in row.items()} for row in csv.DictReader(io.StringIO(done.stdout))]


def caps(rng, width, count, smallest, largest):
    """Random caps, and directions about the mirrored axis; a third of the caps may cross the horizon."""
    rows = []
    while len(rows) < count:
        sigma = width * rng.uniform(smallest, largest)
        theta = rng.uniform(0, math.pi / 2 - (0.0 if len(rows) % 3 == 0 else sigma))
        phi = rng.uniform(0, 2 * math.pi)
        mirror = direction(theta, phi) * [-1, -1, 1]
        wo = around(mirror, np.cos([width * rng.uniform(0, 2)]), np.array([rng.uniform(0, 2 * math.pi)]))[0]
        if wo[2] > 0.05:
            rows.append([theta, phi, 4 * math.pi * math.sin(sigma / 2) ** 2, *wo])
    return rows


def compare(fitter, recipe, properties):
    bsdf = mi.load_dict({"type": "roughconductor", **properties})
    rng = np.random.default_rng(1)
    alphas = [properties[k] for k in ("alpha", "alpha_u", "alpha_v") if k in properties]
    width = min(1.0, math.sqrt(2) * math.sqrt(alphas[0] * alphas[-1]))

    # Caps so small that the mean is the BRDF, above the last degrees where single precision has no cosine to divide by.
    rows = [[min(row[0], 1.5), row[1], 1e-9, *row[3:]] for row in caps(rng, width, 300, 0.01, 0.02)]
    found = run(fitter, ["integrate", recipe, "--samples", "64"], rows)
    point = 0.0
    for row, ours in zip(rows, found):
        theirs = value(bsdf, direction(*row[:2]), row[3:])
        point = max(point, abs(ours["r"] - theirs) / max(theirs, 1e-3))

    # Means by Monte Carlo.
    rows = caps(rng, width, 24, 0.2, 2.5)
    integrated = run(fitter, ["integrate", recipe, "--samples", "65536"], rows)
    theirs = [peer_mean(bsdf, row, rng) for row in rows]
    sigmas = max(
        abs(ours["r"] - mean) / math.hypot(ours["stderr_r"], error) for ours, (mean, error) in zip(integrated, theirs)
    )
    relative = float(np.median([abs(ours["r"] - mean) / mean for ours, (mean, _) in zip(integrated, theirs)]))
    good = point < POINT_TOLERANCE and sigmas < SIGMAS
    print(f"| {recipe} | {point:.1e} | {relative:.1e} | {sigmas:.1f} | {'agrees' if good else 'DIFFERS'} |")
    return good


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    print(f"Mitsuba {mi.__version__}\n")
    print("| material | f_r, largest relative difference | mean, median relative difference | mean, largest in standard errors | |"
          "\n|---|---|---|---|---|")
    results = [compare(sys.argv[1], *material) for material in MATERIALS]
    sys.exit(0 if all(results) else 1)


main()
