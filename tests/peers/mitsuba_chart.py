#!/usr/bin/env python3
"""Adds Mitsuba 3 path tracing, with and without the denoiser OIDN, to a chart of `render chart`.

Usage: mitsuba_chart.py RENDER DIR SCENE.xml [-D name=value …]

RENDER is the program, DIR the folder of a finished chart, SCENE one of its scenes at the size that was charted. Appends
rows to DIR/chart.csv; run the same `render chart` again and the page shows them. Seconds are those of rendering and
denoising, after one run that compiles the kernels; loading is left out, as for our methods.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
import time

try:
    import mitsuba as mi
    import numpy as np

    mi.set_variant("llvm_ad_rgb")
    import mitsuba_phong  # noqa: F401  registers the plugin
except (ImportError, RuntimeError, AttributeError) as missing:
    print(f"skipped: {missing} (pip install mitsuba==3.9.1 numpy, and the LLVM library)")
    sys.exit(0)

try:
    import pyoidn
except ImportError as missing:
    print(f"without the denoiser: {missing} (pip install pyoidn)")
    pyoidn = None

SPP = [4, 16, 64, 256]


def load(path, defines):
    config = mi.parser.ParserConfig(mi.variant())
    config.unused_properties = config.unused_parameters = mi.LogLevel.Debug
    mi.file_resolver().prepend(os.path.dirname(os.path.abspath(path)))
    state = mi.parser.parse_file(config, path, **defines)
    mi.parser.transform_all(config, state)
    scene = mi.parser.instantiate(config, state)
    return scene[0] if isinstance(scene, list) else scene


def render(scene, integrator, spp, seed, denoised):
    layers = np.array(mi.render(scene, integrator=integrator, spp=spp, seed=seed), dtype=np.float32)
    if not denoised:
        return layers[..., :3]
    color, albedo, normal = (np.ascontiguousarray(layers[..., k]) for k in (slice(0, 3), slice(-6, -3), slice(-3, None)))
    return pyoidn.denoise(color, albedo=albedo, normal=normal, hdr=True)


def reference(folder, scene, rows):
    """The reference that the chart kept: the newest of the scene, of the size of its rows."""
    kept = os.path.join(folder, "references")
    names = [n for n in os.listdir(kept) if n.startswith(scene + "-")] if os.path.isdir(kept) else []
    paths = sorted((os.path.join(kept, n) for n in names), key=os.path.getmtime)
    size = [int(rows[-1]["width"]), int(rows[-1]["height"])]
    paths = [p for p in paths if list(mi.Bitmap(p).size()) == size]
    if not paths:
        sys.exit(f"{kept}: no reference of {scene}; pass none to `render chart`, so that it keeps one")
    return paths[-1], size


def main():
    if len(sys.argv) < 4 or len(sys.argv) % 2:
        sys.exit(__doc__)
    program, folder, path = sys.argv[1:4]
    defines = dict(d.split("=", 1) for d in sys.argv[5::2])
    table = os.path.join(folder, "chart.csv")
    with open(table, newline="") as file:
        reader = csv.DictReader(file)
        rows, columns = list(reader), reader.fieldnames
    name = os.path.splitext(os.path.basename(path))[0]
    own = [r for r in rows if r["scene"] == name]
    if not own:
        sys.exit(f"{table}: no rows of {name}; chart it first")
    truth, (width, height) = reference(folder, name, own)
    defines.setdefault("width", str(width))
    defines.setdefault("height", str(height))
    scene = load(path, defines)
    seed = int(own[-1]["seed"])
    plain = scene.integrator()
    layered = mi.load_dict({"type": "aov", "aovs": "albedo:albedo,normal:sh_normal", "image": plain})
    kinds = [("mitsuba", plain, False)] + ([("mitsuba-oidn", layered, True)] if pyoidn else [])
    added = []
    for method, integrator, denoised in kinds:
        for spp in SPP:
            render(scene, integrator, spp, 10**6, denoised)  # compiles
            start = time.perf_counter()
            image = render(scene, integrator, spp, seed, denoised)
            seconds = time.perf_counter() - start
            row = dict.fromkeys(columns, 0)
            row |= {k: own[-1][k] for k in ("scene", "digest", "seed", "width", "height")}
            row |= {"method": method, "setting": f"spp={spp}", "spp": spp, "shade": seconds, "seconds": seconds}
            stem = f"{name}-{row['digest']}-{method}-spp={spp}-{seed}"
            picture = os.path.join(folder, "pictures", stem)
            with tempfile.TemporaryDirectory() as scratch:
                exr = os.path.join(scratch, "image.exr")
                mi.util.write_bitmap(exr, mi.TensorXf(np.ascontiguousarray(image)), write_async=False)
                mi.util.write_bitmap(picture + ".png", mi.TensorXf(np.ascontiguousarray(image)), write_async=False)
                compared = subprocess.run(
                    [program, "compare", exr, truth, "--json", "--false-color", picture + "-difference.png"],
                    capture_output=True, text=True, check=True)
            figures = json.loads(compared.stdout)
            row |= {k: figures[k] for k in figures if k in columns}
            added.append(row)
            print(f"{name}: {method} {spp} spp: {seconds:.2f} s, rel_mse {figures['rel_mse']:.5f}")
    keys = {(r["scene"], r["digest"], r["method"], r["setting"], str(r["seed"])) for r in added}
    rows = [r for r in rows if (r["scene"], r["digest"], r["method"], r["setting"], r["seed"]) not in keys]
    scratch = table + ".new"
    with open(scratch, "w", newline="") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows + added)
    os.replace(scratch, table)


main()
