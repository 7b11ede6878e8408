#!/usr/bin/env python3
"""Reads what `fitter export` and `fitter albedo` write with numpy, json and OpenEXR, and compares it with `fitter query` and with
an integral in numpy.

Usage: export.py FITTER, the path of the fitter program.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import OpenEXR
except ImportError as missing:
    print(f"skipped: {missing} (pip install numpy OpenEXR)")
    sys.exit(0)

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "inputs"))
from make_measured import albedo, ggx

ROOT = pathlib.Path(__file__).parent.parent.parent


def run(*words, text=None):
    return subprocess.run([str(w) for w in words], input=text, capture_output=True, text=True, check=True).stdout


def channels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for name, channel in file.channels().items()}


def directions(data, index):
    """Cap and view of a node, by the words that the file has for it."""
    theta, phi, omega, delta, psi = (data["axes"][name][i] for name, i in zip(data["order"], index))
    st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    m = np.array([-st * cp, -st * sp, ct])
    u, v = np.array([-ct * cp, -ct * sp, -st]), np.array([sp, -cp, 0])
    return theta, phi, omega, np.cos(delta) * m + np.sin(delta) * (np.cos(psi) * u + np.sin(psi) * v)


def main():
    fitter, failed = pathlib.Path(sys.argv[1]).resolve(), False
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name in ("phong-100", "ward-0.1-0.5"):
            table = ROOT / "tables" / f"{name}.tbl"
            for kind in ("json", "npy", "exr"):
                run(fitter, "export", table, "--to", kind, "-o", folder / f"{name}.{kind}")
            data = json.loads((folder / f"{name}.json").read_text())
            values = np.array(data["values"], "f4").reshape(data["shape"])
            array = np.load(folder / f"{name}.npy")
            picture = channels(folder / f"{name}.exr")["Y"].reshape(data["shape"])
            same = np.array_equal(values, array) and np.array_equal(values, picture)
            rng = np.random.default_rng(3)
            nodes = [tuple(rng.integers(n) for n in data["shape"]) for _ in range(400)]
            rows = [(node, directions(data, node)) for node in nodes]
            rows = [(node, d) for node, d in rows if d[3][2] > 1e-6]
            text = "theta_e,phi_e,omega,wo_x,wo_y,wo_z\n"
            text += "".join(f"{t!r},{p!r},{o!r},{w[0]!r},{w[1]!r},{w[2]!r}\n".replace("np.float64(", "").replace(")", "") for _, (t, p, o, w) in rows)
            answers = run(fitter, "query", table, text=text).splitlines()[1:]
            red = np.array([float(line.split(",")[6]) for line in answers])
            mine = np.array([values[node] for node, _ in rows]) * data["ks"][0] + data["kd"][0] / np.pi
            worst = np.max(np.abs(mine - red) / values.max())
            bad = not same or worst > 1e-5
            failed |= bad
            print(f"{'FAILED' if bad else 'agrees'}  {name}: {array.shape}, the three files alike: {same}, query {worst:.1e} of the peak")
        run(fitter, "albedo", "ggx", "--size", 32, "-o", folder / "split.exr")
        split = channels(folder / "split.exr")
        worst = 0.0
        for x, y in ((5, 12), (16, 20), (28, 30), (31, 16)):
            cos, rough = (x + 0.5) / 32, (y + 0.5) / 32
            for f0 in (0.04, 0.9):
                right = albedo(ggx(rough**2, f0, 0.0), np.arccos(cos))[0]
                found = split["R"][y, x] * f0 + split["G"][y, x]
                worst = max(worst, abs(found - right) / right)
        bad = worst > 0.01
        failed |= bad
        print(f"{'FAILED' if bad else 'agrees'}  split sum: {worst:.1e} off an integral in numpy")
    sys.exit(failed)


if __name__ == "__main__":
    main()
