"""Rays per second of the bench `rays` beside Embree 4, one thread each, in turns.

    pip install embreex numpy
    python tests/peers/embree.py [--rounds 3] [--robust]

The bench writes the triangles and rays of every scene it finds and its own seconds; Embree then traces the same rays
through the same triangles (spheres and instances left out: a scene that has some says so by its share of hits). The
quickest round of each counts. What the binding and a ray's set-up take is told last, by rays past a lone triangle: the
binding's part of it burdens Embree's figures.
"""

import argparse
import os
import pathlib
import subprocess
import tempfile
import time

import numpy as np

try:
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh
except ImportError:
    raise SystemExit("skipped: no embreex here (pip install embreex)")

ROOT = pathlib.Path(__file__).parents[2]


def ours(folder, command):
    """Seconds and hits by (scene, purpose)."""
    run = subprocess.run(command, cwd=ROOT, env=os.environ | {"RAYS_EXPORT": folder}, capture_output=True, text=True, check=True)
    rows = (line.split() for line in run.stdout.splitlines())
    return {(name, purpose): (float(seconds), int(hits)) for name, purpose, _, seconds, hits in rows}


def embree(folder, name, purpose, robust, triangles=None):
    """Seconds and hits."""
    if triangles is None:
        triangles = np.fromfile(folder / f"{name}.triangles", np.float32).reshape(-1, 3, 3)
    rays = np.fromfile(folder / f"{name}.{purpose}", np.float32).reshape(-1, 7)
    scene = rtcore_scene.EmbreeScene(robust=robust)
    TriangleMesh(scene, triangles)
    origins, directions = np.ascontiguousarray(rays[:, :3]), np.ascontiguousarray(rays[:, 3:6])
    far = np.minimum(rays[:, 6], 1e37).copy()
    query = "OCCLUDED" if purpose == "Shadow" else "INTERSECT"
    scene.run(origins[:1], directions[:1], dists=far[:1], query=query)  # builds the tree
    best = float("inf")
    for _ in range(5):
        start = time.perf_counter()
        found = scene.run(origins, directions, dists=far, query=query)
        best = min(best, time.perf_counter() - start)
    return best, int((found != -1).sum())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--robust", action="store_true", help="Embree in its watertight mode, which ours always is")
    parser.add_argument("--bench", help="the bench, where it is built already")
    arguments = parser.parse_args()
    command = [arguments.bench, "--bench"] if arguments.bench else ["cargo", "bench", "-q", "-p", "burnish-render", "--bench", "rays"]
    mine, theirs = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.rounds):
            for key, value in ours(folder, command).items():
                mine[key] = min(mine.get(key, value), value)
            for key in mine:
                value = embree(pathlib.Path(folder), *key, arguments.robust)
                theirs[key] = min(theirs.get(key, value), value)
        far_away = 1e6 + np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]], np.float32)
        overhead = {key: embree(pathlib.Path(folder), *key, arguments.robust, far_away)[0] for key in mine}
        counts = {key: os.path.getsize(pathlib.Path(folder) / f"{key[0]}.{key[1]}") // 28 for key in mine}
    print(f"{'scene':18}{'rays':14}{'ours':>8}{'Embree':>8}  million a second; ratio; share of rays that hit")
    for (name, purpose), (seconds, hits) in mine.items():
        count, (other, other_hits) = counts[name, purpose], theirs[name, purpose]
        rates = f"{count / seconds / 1e6:8.2f}{count / other / 1e6:8.2f}"
        print(f"{name:18}{purpose:14}{rates}{other / seconds:8.2f}   {hits / count:.4f} {other_hits / count:.4f}")
    nanoseconds = [1e9 * overhead[key] / counts[key] for key in mine]
    print(f"binding and set-up of Embree: {min(nanoseconds):.0f} to {max(nanoseconds):.0f} ns a ray")


if __name__ == "__main__":
    main()
