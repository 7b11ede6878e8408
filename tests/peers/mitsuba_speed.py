"""Seconds of rendering by path tracing, `render` and Mitsuba 3 in turns on all cores of this machine.

    pip install mitsuba==3.9.1 numpy
    python tests/peers/mitsuba_speed.py target/release/render SCENE.xml --spp 32 [--rounds 3] [-D name=value …]

Rendering alone: Mitsuba after a first picture that compiles its kernels, of `render` what its `--stats` call `shade`. Loading is
told apart: of Mitsuba the call that loads, and the first picture with its kernels. Both pictures must have the same mean, or
what is compared is not the same work: the script fails where they differ by more than a tenth (of published scenes the
kitchenette comes nearest: its light comes in through windows, and 32 samples are far from enough).
"""

import argparse
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
    import drjit as dr
    import mitsuba_phong  # noqa: F401  registers the plugin
except (ImportError, RuntimeError, AttributeError) as missing:
    print(f"skipped: {missing} (pip install mitsuba==3.9.1 numpy, and the LLVM library)")
    sys.exit(0)


def load(path, defines):
    mi.set_log_level(mi.LogLevel.Error)
    config = mi.parser.ParserConfig(mi.variant())
    config.unused_properties = config.unused_parameters = mi.LogLevel.Debug
    mi.file_resolver().prepend(os.path.dirname(os.path.abspath(path)))
    state = mi.parser.parse_file(config, path, **defines)
    mi.parser.transform_all(config, state)
    scene = mi.parser.instantiate(config, state)
    return scene[0] if isinstance(scene, list) else scene


def timed(work):
    start = time.perf_counter()
    result = work()
    return time.perf_counter() - start, result


def theirs(scene, spp, seed):
    """Seconds, and the mean of the picture."""

    def work():
        image = mi.render(scene, spp=spp, seed=seed)
        dr.eval(image)
        dr.sync_thread()
        return image

    seconds, image = timed(work)
    return seconds, float(np.array(image)[..., :3].mean())


def ours(program, path, spp, seed, defines, folder):
    """Seconds of loading, of rendering, and the mean of the picture."""
    stats, picture = os.path.join(folder, "stats.json"), os.path.join(folder, "picture.exr")
    command = [program, "image", path, "--method", "path", "--denoise", "off", "--spp", str(spp), "--seed", str(seed)]
    command += ["-o", picture, "--stats", stats]
    for name, value in defines.items():
        command += ["-D", f"{name}={value}"]
    subprocess.run(command, check=True, capture_output=True)
    with open(stats) as file:
        figures = json.load(file)
    image = dict(mi.Bitmap(picture).split())["<root>"]
    return figures["seconds"]["load"], figures["seconds"]["shade"], float(np.array(image)[..., :3].mean())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("scene")
    parser.add_argument("--spp", type=int, default=32)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("-D", action="append", default=[], metavar="NAME=VALUE")
    arguments = parser.parse_args()
    defines = dict(d.split("=", 1) for d in arguments.D)
    loaded, scene = timed(lambda: load(arguments.scene, defines))
    compiled, _ = theirs(scene, arguments.spp, 10**6)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, arguments.rounds + 1):
            mine = ours(arguments.program, arguments.scene, arguments.spp, seed, defines, folder)
            rows.append((*mine, *theirs(scene, arguments.spp, seed)))
    loads, shades, means, others, other_means = zip(*rows)

    def listed(seconds):
        return ", ".join(f"{s:.2f}" for s in seconds)

    print(f"{arguments.scene}, {arguments.spp} spp: render {listed(shades)}; Mitsuba {listed(others)}; "
          f"ratio of the best {min(others) / min(shades):.2f}")
    print(f"  loading: render {listed(loads)}; Mitsuba {loaded:.2f}, and {compiled:.2f} of a first picture with its kernels")
    mine, other = sum(means) / len(means), sum(other_means) / len(other_means)
    print(f"  means: {mine:.5f}, {other:.5f}")
    if not abs(mine - other) <= 0.1 * other:
        sys.exit("the pictures differ")


main()
