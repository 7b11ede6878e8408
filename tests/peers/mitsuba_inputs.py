"""The inputs of tests/inputs/valid, drawn by `render` and by Mitsuba 3: means of the picture side by side.

A case is left out where it is not Mitsuba XML, and where its `expected.toml` says in `peer` why Mitsuba cannot be asked.
Every other one must be read by both, with means that agree within the tolerance of the case and the noise of both.

  pip install mitsuba==3.9.1 numpy
  python tests/peers/mitsuba_inputs.py target/release/render [KIND …]
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib

try:
    import mitsuba as mi
    import numpy as np

    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(0)

ROOT = pathlib.Path(__file__).resolve().parent.parent / "inputs" / "valid"
SPP = 256
SEEDS = 4


def peer(path, defines):
    """Mean of Mitsuba's picture, and its standard error over independent seeds."""
    config = mi.parser.ParserConfig(mi.variant())
    config.unused_properties = mi.LogLevel.Debug
    config.unused_parameters = mi.LogLevel.Debug
    mi.file_resolver().prepend(str(path.parent))
    state = mi.parser.parse_file(config, str(path), **defines)
    mi.parser.transform_all(config, state)
    scene = mi.parser.instantiate(config, state)
    scene = scene[0] if isinstance(scene, list) else scene
    integrator = scene.integrator() or mi.load_dict({"type": "path"})
    draw = lambda seed: np.array(mi.render(scene, integrator=integrator, spp=SPP // SEEDS, seed=seed), dtype=np.float64)
    pictures = [draw(seed) for seed in range(SEEDS)]
    means = np.array([np.broadcast_to(p[..., :3], p.shape[:2] + (3,)).mean((0, 1)) for p in pictures])
    return means.mean(0), means.std(0, ddof=1) / np.sqrt(SEEDS)


def ours(render, path, args, folder):
    """Mean of our picture, and its standard error from the differences of two seeds."""
    means = []
    for seed in (1, 2):
        out = os.path.join(folder, "out.exr")
        command = [render, "image", path.name, "-o", out, *args, "--seed", str(seed)]
        subprocess.run(command, cwd=path.parent, check=True, capture_output=True)
        layers = dict(mi.Bitmap(out).split())
        means.append(np.array(layers["<root>"], dtype=np.float64)[..., :3].mean((0, 1)))
    return np.mean(means, 0), np.abs(means[0] - means[1]) / 2


def main():
    render = os.path.abspath(sys.argv[1])
    kinds = [ROOT / kind for kind in sys.argv[2:]] or sorted(ROOT.iterdir())
    wrong = checked = left_out = 0
    with tempfile.TemporaryDirectory() as folder:
        for kind in kinds:
            if not (kind / "expected.toml").exists():
                continue
            for case in tomllib.loads((kind / "expected.toml").read_text())["case"]:
                scene = case.get("scene", "")
                if not scene.endswith(".xml") or "peer" in case:
                    left_out += 1
                    continue
                args = case.get("args", [])
                defines = dict(args[i + 1].split("=", 1) for i, a in enumerate(args) if a == "-D")
                name = f"{kind.name}/{scene} {' '.join(args)}"
                checked += 1
                try:
                    theirs, error = peer(kind / scene, defines)
                except Exception as problem:
                    wrong += 1
                    print(f"WRONG {name}: Mitsuba does not read it: {' '.join(str(problem).split())[:200]}")
                    continue
                mine, own_error = ours(render, kind / scene, args, folder)
                allowed = case.get("tolerance", 0.002) + 3 * (error + own_error)
                good = bool((np.abs(mine - theirs) <= allowed).all())
                wrong += not good
                numbers = lambda v: " ".join(f"{x:.4f}" for x in v)
                print(f"{'     ' if good else 'WRONG'} {name}: ours {numbers(mine)}, Mitsuba {numbers(theirs)}")
    print(f"{checked} checked, {wrong} wrong, {left_out} left out")
    return 1 if wrong else 0


sys.exit(main())
