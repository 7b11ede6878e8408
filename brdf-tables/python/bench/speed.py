"""Look-ups from Python beside the same in Rust, in turns: `python bench/speed.py` (builds the Rust example `arrays`).

Both read the same arrays of float32: 128 caps seen from 800 directions, and 100 000 pairs one by one. The least time of each
of several turns counts. The exit code is 1 where Python takes more than 1.3 times as long.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import brdf_tables
import numpy as np

ROOT = Path(__file__).resolve().parents[3]
TURNS, WORST = 7, 1.3
RECIPES = {"phong-100": "phong:exponent=100", "ggx-0.1": "ggx:alpha=0.1", "ward-0.1-0.5": "ward:alpha_x=0.1,alpha_y=0.5"}


def directions(n: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(0.1, 1.0, n), rng.uniform(0.0, 2.0 * np.pi, n)
    s = np.sqrt(1.0 - z * z)
    return np.stack([s * np.cos(phi), s * np.sin(phi), z], axis=-1).astype(np.float32)


def python_seconds(table: brdf_tables.Table, axis: np.ndarray, omega: np.ndarray, wo: np.ndarray) -> float:
    start = time.perf_counter()
    table.specular(axis, omega, wo)
    return time.perf_counter() - start


def main() -> None:
    build = ["cargo", "build", "--release", "-q", "-p", "brdf-tables", "--example", "arrays", *sys.argv[1:]]
    subprocess.run(build, cwd=ROOT, check=True)
    program = ROOT / "target" / "release" / "examples" / "arrays"
    omega = lambda n: np.random.default_rng(9).uniform(0.001, 0.2, n).astype(np.float32)
    cases = {
        "128 caps x 800 views": (directions(128, 1), omega(128), directions(800, 2)),
        "100000 pairs": (directions(100_000, 3), omega(100_000), directions(100_000, 4)),
    }
    bad = False
    with tempfile.TemporaryDirectory() as folder:
        for case, (axis, omega, wo) in cases.items():
            pairs = len(axis) == len(wo)
            files = [Path(folder, name) for name in ("axis", "omega", "wo")]
            for file, array in zip(files, (axis, omega, wo)):
                file.write_bytes(array.tobytes())
            for name in RECIPES:
                path = ROOT / "tables" / f"{name}.tbl"
                table, view = brdf_tables.Table.load(path), wo if pairs else wo[:, None]
                ours, theirs = [], []
                for _ in range(TURNS):
                    ours += [python_seconds(table, axis, omega, view) for _ in range(5)]
                    command = [program, path, *files, "pairs" if pairs else "all"]
                    theirs.append(float(subprocess.run(command, capture_output=True, text=True, check=True).stdout))
                count = len(axis) * (1 if pairs else len(wo))
                ours, theirs = (1e9 * min(t) / count for t in (ours, theirs))
                bad |= ours > WORST * theirs
                print(f"{case:22} {name:14} Python {ours:6.1f} ns, Rust {theirs:6.1f} ns: {ours / theirs:.2f} times")
    sys.exit(bad)


if __name__ == "__main__":
    main()
