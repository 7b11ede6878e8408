#!/usr/bin/env python3
"""Runs the jobs of render/farm: the template with Open Job Description's own runner, the script with Slurm's.

Usage: farm.py RENDER, RENDER the path of the render program.

A small walk of the glossy box is filled in two chunks and drawn in three. Then frames are lost, one is cut short, and the step
that draws runs again; the frames must have the same bytes. Fails where they do not, or where a job ends with an error. Of Slurm,
where it is installed, every step is tried with `sbatch --test-only`.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
FARM = ROOT / "render" / "farm"
SCENE = ROOT / "tests" / "scenes" / "cornell-glossy.xml"
PATH = ROOT / "tests" / "scenes" / "cornell-walk.csv"
LAST = 60
OPTIONS = "--method auto --width 32 --tau 0.2 --spp 1"


def openjd(render, out):
    if not shutil.which("openjd"):
        return print("skipped: Open Job Description (pip install openjd-cli)")
    parameters = {
        "Scene": SCENE, "Path": PATH, "Out": out, "Last": LAST, "FillChunk": 30, "DrawChunk": 20, "Render": render,
        "Options": OPTIONS,
    }
    given = [part for name, value in parameters.items() for part in ("-p", f"{name}={value}")]

    def run(*step):
        command = ["openjd", "run", str(FARM / "walk.template.yaml"), *step, *given]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"openjd ended with {done.returncode}:\n{done.stdout[-4000:]}{done.stderr[-2000:]}")
        return done.stdout

    log = run("--step", "Draw", "--run-dependencies")
    frames = {path.name: path.read_bytes() for path in out.glob("*.exr")}
    assert len(frames) == LAST, f"{len(frames)} frames"
    assert "openjd_progress: " in log, "no progress was told"
    (out / "0007.exr").unlink()
    (out / "0030.exr").write_bytes(frames["0030.exr"][:1000])
    log = run("--step", "Draw")
    again = {path.name: path.read_bytes() for path in out.glob("*.exr")}
    assert again == frames, "frames that were drawn again differ"
    assert "19 were there" in log, "frames that were there were drawn again"
    print(f"Open Job Description: {LAST} frames, two of them lost and drawn again: the same bytes")


def slurm(render, out):
    if not shutil.which("sbatch"):
        return print("skipped: Slurm (apt install slurm-wlm, and a cluster of one node)")
    environment = os.environ | {
        "SCENE": str(SCENE), "CAMERA_PATH": str(PATH), "OUT": str(out), "LAST": str(LAST), "RENDER": render,
        "OPTIONS": OPTIONS,
    }
    for step in ["tables", "fill", "merge", "draw"]:
        command = ["sbatch", "--test-only", "--array=0-1", str(FARM / "walk.slurm.sh"), step]
        subprocess.run(command, env=environment, check=True)
    print("Slurm: would take every step")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    render = os.path.abspath(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        openjd(render, pathlib.Path(folder) / "openjd")
        slurm(render, pathlib.Path(folder) / "slurm")


main()
