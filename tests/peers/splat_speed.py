"""Who sums the records of a pixel faster: pixels that look in an octree, or tiles onto which records are drawn.

    python tests/peers/splat_speed.py target/release/render SCENE.xml [SCENE.xml …] [--sizes 256,1024] [--taus 0.1,0.05] [--methods irradiance,eas]

The same records for all; indirect light alone, one sample per pixel, one thread, the fastest of some turns in alternation. Prints a row of a
table for each scene, method, τ and size, and fails where the pictures of the processor have not the same bytes. Sizes are the longer side of
the film. `--ways octree,splat,gpu` sets the graphics card beside them, in a build that has it.
"""

import argparse
import filecmp
import json
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path


def film(scene):
    """Width and height that a scene asks for."""
    root = ElementTree.parse(scene).getroot()
    defaults = {f"${d.get('name')}": d.get("value") for d in root.iter("default")}
    sizes = {i.get("name"): i.get("value") for i in root.find(".//film").iter("integer")}
    return [int(defaults.get(sizes[k], sizes[k])) for k in ("width", "height")]


def run(command):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr.strip()}")


def measure(args, scene, method, tau, size, folder):
    width, height = film(scene)
    width, height = [max(1, round(x * size / max(width, height))) for x in (width, height)]
    command = [args.render, "image", scene, "--method", method, "--tau", tau, "--width", width, "--height", height, "--spp", 1]
    command += ["--denoise", "off", "--threads", args.threads, "--cache", folder / "records.cache"]
    if args.tables and method != "irradiance":
        command += ["--tables", args.tables]
    run([*command, "-o", folder / "first.exr"])
    best = dict.fromkeys(args.ways, float("inf"))
    for _ in range(args.turns):
        for way in args.ways:
            run([*command, "--interpolation", way, "--stats", folder / "stats.json", "-o", folder / f"{way}.exr"])
            stats = json.loads((folder / "stats.json").read_text())
            best[way] = min(best[way], stats["seconds"]["indirect"])
    same = [folder / f"{way}.exr" for way in args.ways if way != "gpu"]
    assert all(filecmp.cmp(same[0], other, shallow=False) for other in same[1:]), f"{scene}: the pictures differ"
    name = Path(scene).stem if Path(scene).stem != "scene" else Path(scene).parent.name
    times = [f"{1000 * best[way]:.0f}" for way in args.ways]
    last = f"{best['octree'] / best['splat']:.2f}×" if {"octree", "splat"} <= set(args.ways) else ""
    print(f"| {name} | {method} | {tau} | {width} × {height} | {stats['records']} | {' | '.join(times)} | {last} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("render")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--sizes", type=lambda s: list(map(int, s.split(","))), default=[256, 1024])
    parser.add_argument("--taus", type=lambda s: s.split(","), default=["0.1", "0.05"])
    parser.add_argument("--methods", type=lambda s: s.split(","), default=["irradiance", "eas"])
    parser.add_argument("--ways", type=lambda s: s.split(","), default=["octree", "splat"])
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--turns", type=int, default=2)
    parser.add_argument("--tables", help="a folder of fitted tables")
    args = parser.parse_args()
    print(f"| scene | method | τ | pixels | records | {' | '.join(f'{way}, ms' for way in args.ways)} | |\n|---|---|---|---|---|{'---|' * len(args.ways)}---|")
    for scene in args.scenes:
        for method in args.methods:
            for tau in args.taus:
                for size in args.sizes:
                    with tempfile.TemporaryDirectory() as folder:
                        measure(args, scene, method, tau, size, Path(folder))


if __name__ == "__main__":
    main()
